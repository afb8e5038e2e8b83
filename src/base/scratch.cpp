#include "base/scratch.hpp"

#include <algorithm>
#include <cassert>
#include <cstdlib>
#include <exception>
#include <functional>
#include <iterator>

#include "base/growth.hpp"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/asan_interface.h>
static void hide(const void* memory, std::size_t bytes) { ASAN_POISON_MEMORY_REGION(memory, bytes); }
static void show(const void* memory, std::size_t bytes) { ASAN_UNPOISON_MEMORY_REGION(memory, bytes); }
#else
static void hide(const void*, std::size_t) {}
static void show(const void*, std::size_t) {}
#endif

namespace trevi {

namespace {

// Memory that is read before it is written yields NaNs: in builds with asserts, and where tests ask for it.
void spoil(void* memory, std::size_t bytes) {
#if defined(NDEBUG)
  static const bool is_asked_for = std::getenv("TREVI_SPOIL_SCRATCH") != nullptr;
#else
  constexpr bool is_asked_for = true;
#endif
  if (is_asked_for) std::fill_n(static_cast<unsigned char*>(memory), bytes, 0xFF);
}

std::size_t rounded(std::size_t bytes, std::size_t unit) {
  return std::max<std::size_t>((bytes + unit - 1) / unit, 1) * unit;
}

}  // namespace

Scratch::~Scratch() {
  assert(borrowed_ == 0);
  for (const Piece& piece : pieces_) show(piece.memory, piece.size);
}

Scratch::Piece Scratch::piece_of(std::size_t size) {
  auto* const memory = static_cast<std::byte*>(::operator new[](size, std::align_val_t(alignment)));
  hide(memory, size);
  return {std::unique_ptr<std::byte[], Free>(memory), memory, size, {}};
}

// Takes the smallest gap that is large enough, the first of several; null if there is none. Adjacent runs are merged,
// so that with thousands of pages taken one after another the search does not visit each of them.
std::byte* Scratch::place_in(Piece& piece, std::size_t size) {
  std::size_t begin = 0, least = piece.size + 1, at = 0;
  auto next = piece.taken.end();
  for (auto run = piece.taken.begin();; at = (run++)->end) {
    const std::size_t gap = (run == piece.taken.end() ? piece.size : run->begin) - at;
    if (gap >= size && gap < least) {
      least = gap;
      begin = at;
      next = run;
    }
    if (run == piece.taken.end()) break;
  }
  if (least > piece.size) return nullptr;
  const std::size_t end = begin + size;
  const bool meets_next = next != piece.taken.end() && next->begin == end;
  if (begin > 0) {
    const auto last = std::prev(next);
    last->end = meets_next ? next->end : end;
    if (meets_next) piece.taken.erase(next);
  } else if (meets_next) {
    next->begin = 0;
  } else {
    piece.taken.insert(next, {0, end});
  }
  return piece.memory + begin;
}

void Scratch::leave(Piece& piece, const Run& left) {
  const auto after = std::upper_bound(piece.taken.begin(), piece.taken.end(), left.begin,
                                      [](std::size_t place, const Run& run) { return place < run.begin; });
  assert(after != piece.taken.begin() && std::prev(after)->end >= left.end);
  const auto run = std::prev(after);
  const Run rest{left.end, run->end};
  run->end = left.begin;
  const bool is_empty = run->begin == run->end;
  if (rest.begin == rest.end) {
    if (is_empty) piece.taken.erase(run);
  } else if (is_empty) {
    *run = rest;
  } else {
    piece.taken.insert(after, rest);
  }
}

void* Scratch::take(std::size_t bytes, bool briefly) {
  const std::size_t size = rounded(bytes, alignment);
  const std::lock_guard<std::mutex> lock(mutex_);
  std::byte* memory = nullptr;
  for (const bool own : {false, true}) {
    for (Piece& piece : pieces_) {
      if (memory != nullptr || (piece.own != nullptr) != own || (!own && !briefly)) continue;
      memory = place_in(piece, size);
      if (memory != nullptr && own) borrowed_ += size;
    }
  }
  if (memory == nullptr) {
    pieces_.push_back(piece_of(size));
    memory = place_in(pieces_.back(), size);
    borrowed_ += size;
  }
  most_ = std::max(most_, borrowed_);
  show(memory, bytes);
  spoil(memory, bytes);
  return memory;
}

void Scratch::give_back(void* memory, std::size_t bytes) {
  const std::size_t size = rounded(bytes, alignment);
  spoil(memory, bytes);
  hide(memory, bytes);
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto* const begin = static_cast<std::byte*>(memory);
  for (Piece& piece : pieces_) {
    if (std::less<>()(begin, piece.memory) || !std::less<>()(begin, piece.memory + piece.size)) continue;
    const auto at = static_cast<std::size_t>(begin - piece.memory);
    leave(piece, {at, at + size});
    if (piece.own != nullptr) borrowed_ -= size;
    return;
  }  // a loan that was ended by an exception is not among them
}

void Scratch::give_back_end(void* memory, std::size_t bytes, std::size_t kept) {
  const std::size_t begin = rounded(kept, alignment);
  if (begin < bytes) give_back(static_cast<std::byte*>(memory) + begin, bytes - begin);
}

// Addresses in lent memory are those of numbers: the part before the first whole unit is not used.
void Scratch::lend(std::span<std::byte> memory) {
  void* first = memory.data();
  std::size_t size = memory.size();
  const bool any = std::align(alignment, alignment, first, size) != nullptr;
  const std::lock_guard<std::mutex> lock(mutex_);
  pieces_.push_back({nullptr, any ? static_cast<std::byte*>(first) : memory.data(), any ? size : 0, {}});
}

void Scratch::end_loan(const std::byte* memory) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto lent = std::find_if(pieces_.begin(), pieces_.end(), [&](const Piece& piece) {
    return piece.own == nullptr && piece.memory >= memory && piece.memory - memory < std::ptrdiff_t{alignment};
  });
  assert(lent != pieces_.end() && (lent->taken.empty() || std::uncaught_exceptions() > 0));
  show(lent->memory, lent->size);
  pieces_.erase(lent);
}

void Scratch::join() {
  if (borrowed_ > 0 || pieces_.size() < 2) return;
  // The first piece was too small, by how much is not known: arrays that found no gap would have, one after the other.
  constexpr std::size_t fraction = 64;
  const std::size_t size = rounded(std::max(most_, joined_) + most_ / fraction, alignment);
  joined_ = size;
  for (const Piece& piece : pieces_) show(piece.memory, piece.size);
  pieces_.clear();  // before the new memory is requested
  pieces_.push_back(piece_of(size));
  show(pieces_.back().memory, size);
  touch_pages(pieces_.back().memory, size);
  hide(pieces_.back().memory, size);
}

std::size_t Scratch::bytes() const {
  std::size_t sum = 0;
  for (const Piece& piece : pieces_) sum += piece.own != nullptr ? piece.size : 0;
  return sum;
}

}  // namespace trevi
