// libFuzzer target: what a viewer and a run take from the line. The input is the text of a message, then, after a NUL,
// the bytes of a frame's particles. Whatever it is, the answer is a message or none; of a frame the counts of the ranks
// are those of its particles, and each message that was taken is taken again when it is written anew. Built with
// TREVI_FUZZ.
#include <cstdlib>
#include <numeric>
#include <string>

#include "live/viewer_messages.hpp"

namespace {

void check(bool holds) {
  if (!holds) std::abort();
}

void check_frame(const std::string& text, const std::string& bytes) {
  const auto frame = trevi::read_frame(text, bytes);
  if (!frame) return;
  std::int64_t counted = 0;
  for (const std::int64_t count : frame->rank_counts) {
    check(count >= 0);
    counted += count;
  }
  check(counted == static_cast<std::int64_t>(frame->shown.size()));
  check(frame->shown.size() * sizeof(trevi::ViewedParticle) == bytes.size());
  check(frame->level >= 0 && frame->level < 63);
  check(trevi::read_frame(trevi::text_of(*frame), bytes).has_value());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const std::string all(reinterpret_cast<const char*>(data), size);
  const std::size_t end = std::min(all.find('\0'), size);
  const std::string text = all.substr(0, end), bytes = all.substr(std::min(end + 1, size));
  check_frame(text, bytes);
  if (const auto scene = trevi::read_scene(text)) check(trevi::read_scene(trevi::text_of(*scene)).has_value());
  if (const auto wishes = trevi::read_wishes(text)) check(trevi::read_wishes(trevi::text_of(*wishes)).has_value());
  if (const auto reason = trevi::read_end(text)) check(trevi::read_end(trevi::text_of_end(*reason)).has_value());
  return 0;
}
