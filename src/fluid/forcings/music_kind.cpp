#include "fluid/forcings/music_kind.hpp"

#include <algorithm>
#include <cctype>

namespace trevi {

namespace {

struct Ending {
  const char* text;
  MusicKind kind;
};

constexpr Ending endings[] = {{".txt", MusicKind::score}, {".mid", MusicKind::midi},   {".midi", MusicKind::midi},
                              {".wav", MusicKind::sound}, {".flac", MusicKind::sound}, {".ogg", MusicKind::sound},
                              {".mp3", MusicKind::sound}, {".aif", MusicKind::sound},  {".aiff", MusicKind::sound},
                              {".au", MusicKind::sound},  {".snd", MusicKind::sound}};

}  // namespace

std::optional<MusicKind> kind_of_music(std::string source) {
  if (source == "-") return MusicKind::live;
  std::transform(source.begin(), source.end(), source.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const Ending& ending : endings) {
    if (source.ends_with(ending.text)) return ending.kind;
  }
  return std::nullopt;
}

std::string endings_of_music() {
  std::string text;
  for (const Ending& ending : endings) text.append(text.empty() ? "" : " ").append(ending.text);
  return text;
}

void resolve(MusicSettings& music) {
  if (const auto kind = kind_of_music(music.source)) music.kind.set_default(*kind);
  const bool is_sound = music.kind == MusicKind::sound || music.kind == MusicKind::live;
  music.follow.set_default(is_sound ? Follow::loudness : Follow::pitch);
}

}  // namespace trevi
