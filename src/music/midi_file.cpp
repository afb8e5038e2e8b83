#include "music/midi_file.hpp"

#include <algorithm>
#include <cstdint>

#include "trevi/error.hpp"

namespace trevi {

namespace {

/// The largest time that one event can hold, four bytes of seven bits; no piece comes near it.
constexpr std::int64_t max_ticks = (1 << 28) - 1;

/// A position in the file that moves forward and never beyond the end, neither of the file nor of a chunk.
class Cursor {
 public:
  Cursor(const std::string& name, const std::string& bytes) : name_(name), bytes_(bytes), end_(bytes.size()) {}

  [[noreturn]] void fail(const std::string& what) const { fail_at(at_, what); }
  [[noreturn]] void fail_at(std::size_t at, const std::string& what) const {
    throw InputError(name_ + ": byte " + std::to_string(at) + ": " + what + "; export or copy the MIDI file again");
  }

  std::size_t at() const { return at_; }
  bool at_end() const { return at_ == end_; }

  int byte(const char* of) {
    need(1, of);
    return static_cast<unsigned char>(bytes_[at_++]);
  }
  std::int64_t big_endian(int size, const char* of) {
    need(static_cast<std::size_t>(size), of);
    std::int64_t value = 0;
    for (int i = 0; i < size; ++i) value = value << 8 | byte(of);
    return value;
  }
  std::int64_t variable_length(const char* of) {
    std::int64_t value = 0;
    for (int i = 0; i < 4; ++i) {
      const int next = byte(of);
      value = value << 7 | (next & 0x7f);
      if (next < 0x80) return value;
    }
    fail(std::string(of) + " is longer than 4 bytes");
  }
  void skip(std::int64_t size, const char* of) {
    need(static_cast<std::size_t>(size), of);
    at_ += static_cast<std::size_t>(size);
  }
  bool word(const char* four) {
    need(4, "the name of a chunk");
    if (bytes_.compare(at_, 4, four) != 0) return false;
    at_ += 4;
    return true;
  }
  /// From here on the end is that of a chunk; returns the previous end.
  std::size_t enter(std::int64_t length) {
    need(static_cast<std::size_t>(length), "a chunk");
    const std::size_t outer = end_;
    end_ = at_ + static_cast<std::size_t>(length);
    return outer;
  }
  void leave(std::size_t outer) {
    at_ = end_;
    end_ = outer;
  }

 private:
  void need(std::size_t size, const char* of) const {
    if (size <= end_ - at_) return;
    if (end_ < bytes_.size()) fail_at(end_, std::string("the track ends within ") + of);
    fail_at(bytes_.size(), std::string("the file ends within ") + of + ", so it is cut short");
  }

  const std::string& name_;
  const std::string& bytes_;
  std::size_t at_ = 0, end_;
};

struct Tempo {
  std::int64_t tick = 0;       ///< from which it applies
  Real microseconds = 500000;  ///< per quarter note; the default of the format
  Real time = 0;               ///< s, of that tick
};

/// Converts ticks to seconds.
class TempoMap {
 public:
  /// `changes` in the order of the tracks; of those at one tick the last applies.
  TempoMap(std::vector<Tempo> changes, std::int64_t ticks_per_quarter) : ticks_(static_cast<Real>(ticks_per_quarter)) {
    std::stable_sort(changes.begin(), changes.end(), [](const auto& a, const auto& b) { return a.tick < b.tick; });
    for (Tempo& change : changes) {
      change.time = seconds(change.tick);
      if (change.tick == map_.back().tick) map_.pop_back();
      map_.push_back(change);
    }
  }

  Real seconds(std::int64_t tick) const {
    const auto after = std::upper_bound(map_.begin(), map_.end(), tick,
                                        [](std::int64_t t, const Tempo& tempo) { return t < tempo.tick; });
    const Tempo& now = *std::prev(after);
    return now.time + static_cast<Real>(tick - now.tick) * (now.microseconds / (ticks_ * 1e6));
  }

 private:
  Real ticks_;
  std::vector<Tempo> map_{1};
};

/// The content of a file, in ticks.
struct Contents {
  MidiFile file;
  std::vector<Tempo> tempi;
  std::int64_t last_tick = 0;
};

class TrackReader {
 public:
  TrackReader(Cursor& cursor, int number, Contents& contents)
      : cursor_(cursor), number_(number), name_("track " + std::to_string(number)), contents_(contents) {}

  void read() {
    while (!ended_) {
      if (cursor_.at_end()) cursor_.fail(name_ + " has no end-of-track event");
      tick_ += cursor_.variable_length("the time of an event");
      if (tick_ > max_ticks) cursor_.fail(name_ + " lasts more than 2^28 ticks");
      read_event();
    }
    contents_.last_tick = std::max(contents_.last_tick, tick_);
  }

 private:
  void read_event() {
    const std::size_t at = cursor_.at();
    const int first = cursor_.byte("an event");
    if (first == 0xff) return read_meta(at);
    if (first == 0xf0 || first == 0xf7)
      return cursor_.skip(cursor_.variable_length("the length of an event"), "an event");
    if (first >= 0xf0) cursor_.fail_at(at, "no event of a file begins with this byte");
    if (first < 0x80 && status_ == 0) cursor_.fail_at(at, "an event without a status byte");
    if (first >= 0x80) status_ = first;
    read_channel_event(first < 0x80 ? first : cursor_.byte("an event"));
  }

  void read_channel_event(int data) {
    const int kind = status_ & 0xf0;
    if (data >= 0x80) cursor_.fail_at(cursor_.at() - 1, "a data byte is over 127");
    if (kind == 0xc0 || kind == 0xd0) return;
    const int more = cursor_.byte("an event");
    if (more >= 0x80) cursor_.fail_at(cursor_.at() - 1, "a data byte is over 127");
    if (kind != 0x80 && kind != 0x90) return;
    contents_.file.events.push_back({tick_, number_, (status_ & 0x0f) + 1, data, kind == 0x90 && more > 0});
  }

  void read_meta(std::size_t at) {
    const int type = cursor_.byte("an event");
    const std::int64_t length = cursor_.variable_length("the length of an event");
    ended_ = type == 0x2f;
    if (type != 0x51) return cursor_.skip(length, "an event");
    if (length != 3) cursor_.fail_at(at, "a change of tempo must be 3 bytes long");
    const std::int64_t microseconds = cursor_.big_endian(3, "an event");
    if (microseconds == 0) cursor_.fail_at(at, "a tempo must not be 0");
    contents_.tempi.push_back({tick_, static_cast<Real>(microseconds)});
  }

  Cursor& cursor_;
  int number_;
  std::string name_;
  Contents& contents_;
  std::int64_t tick_ = 0;
  int status_ = 0;
  bool ended_ = false;
};

struct Header {
  std::int64_t tracks, ticks_per_quarter;
};

Header read_header(Cursor& cursor, const std::string& bytes) {
  if (bytes.empty()) cursor.fail("the file is empty");
  if (bytes.compare(0, 4, "MThd", 0, std::min<std::size_t>(4, bytes.size())) != 0)
    cursor.fail("not a Standard MIDI File, which begins with MThd");
  cursor.skip(4, "the header");
  if (cursor.big_endian(4, "the header") != 6) cursor.fail("the header must be 6 bytes long");
  const std::int64_t format = cursor.big_endian(2, "the header");
  if (format == 2)
    cursor.fail("format 2, several pieces in one file, which do not sound together; save one as format 1");
  if (format > 2) cursor.fail("format " + std::to_string(format) + " is none that there is; copy the file again");
  const std::int64_t tracks = cursor.big_endian(2, "the header");
  if (tracks < 1) cursor.fail("there is no track");
  const std::int64_t division = cursor.big_endian(2, "the header");
  if (division == 0) cursor.fail("0 ticks per quarter note (the division of the header); save the file again");
  if (division >= 0x8000) {
    cursor.fail("times in SMPTE frames (" + std::to_string(256 - division / 256) +
                " a second); save it with ticks per quarter note");
  }
  return {tracks, division};
}

}  // namespace

MidiFile read_midi_file(const std::string& name, const std::string& bytes) {
  Cursor cursor(name, bytes);
  const Header header = read_header(cursor, bytes);
  Contents contents;
  for (int tracks = 0; tracks < header.tracks;) {
    if (cursor.at_end()) {
      cursor.fail("the file ends after " + std::to_string(tracks) + " of " + std::to_string(header.tracks) +
                  " tracks, so it is cut short");
    }
    const bool is_track = cursor.word("MTrk");
    if (!is_track) cursor.skip(4, "the name of a chunk");  // other kinds of chunks are allowed anywhere
    const std::size_t outer = cursor.enter(cursor.big_endian(4, "the length of a chunk"));
    if (is_track) TrackReader(cursor, ++tracks, contents).read();
    cursor.leave(outer);
  }
  const TempoMap tempi(std::move(contents.tempi), header.ticks_per_quarter);
  for (MidiEvent& event : contents.file.events) event.time = tempi.seconds(event.tick);
  contents.file.length = tempi.seconds(contents.last_tick);
  return std::move(contents.file);
}

}  // namespace trevi
