// Memory that the stages of a step share: each borrows its arrays here and gives them back when it is done, so that
// arrays of one stage reuse the memory of those of another. An array is given back by the end of its Borrowed, and its
// memory is uninitialized at first. Addresses depend on what was borrowed before, so no result may depend on them. A
// build with the address sanitizer fails when memory is used after it was given back; in a build with asserts, and
// where TREVI_SPOIL_SCRATCH is set, as in all tests, memory is filled with NaNs when it is borrowed. Not collective;
// several threads may borrow and give back at the same time.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/threads.hpp"

namespace trevi {

template <class T>
class Borrowed;

class Scratch {
 public:
  Scratch() = default;
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch();

  /// An uninitialized array of n values.
  template <class T>
  Borrowed<T> borrow(std::size_t n) {
    return {*this, n, false};
  }
  /// The same for a stage that ends before any loan does: the array may be in lent memory.
  template <class T>
  Borrowed<T> borrow_briefly(std::size_t n) {
    return {*this, n, true};
  }

  /// To be called between stages when nothing is borrowed: memory that consists of several pieces becomes one piece.
  void join();

  /// Memory of its own, without lent memory.
  std::size_t bytes() const;
  /// Bytes that are borrowed now.
  std::size_t borrowed() const { return borrowed_; }

 private:
  template <class T>
  friend class Borrowed;
  friend class Loan;
  static constexpr std::size_t alignment = 128;  // no two arrays in one pair of cache lines
  struct Run {
    std::size_t begin, end;
  };
  struct Free {
    void operator()(std::byte* memory) const { ::operator delete[](memory, std::align_val_t(alignment)); }
  };
  struct Piece {
    std::unique_ptr<std::byte[], Free> own;  // null if it is lent
    std::byte* memory;
    std::size_t size;
    std::vector<Run> taken;  // in their order; none is adjacent to another
  };
  static Piece piece_of(std::size_t size);
  static std::byte* place_in(Piece& piece, std::size_t size);
  static void leave(Piece& piece, const Run& left);
  void* take(std::size_t bytes, bool briefly);
  void give_back(void* memory, std::size_t bytes);
  void give_back_end(void* memory, std::size_t bytes, std::size_t kept);
  void lend(std::span<std::byte> memory);
  void end_loan(const std::byte* memory);

  std::mutex mutex_;
  std::vector<Piece> pieces_;
  std::size_t borrowed_ = 0, most_ = 0;  // without arrays in lent memory; most_: the largest at any time
  std::size_t joined_ = 0;               // size of the piece that join() has made
};

/// Lends memory that its owner does not need to a Scratch, until the end of the object.
class Loan {
 public:
  Loan(Scratch& scratch, std::span<std::byte> memory) : scratch_(scratch), memory_(memory.data()) {
    scratch_.lend(memory);
  }
  ~Loan() { scratch_.end_loan(memory_); }
  Loan(const Loan&) = delete;
  Loan& operator=(const Loan&) = delete;

 private:
  Scratch& scratch_;
  const std::byte* memory_;
};

/// An array in a Scratch, which outlives it; empty if nothing is borrowed.
template <class T>
class Borrowed {
  static_assert(std::is_trivially_destructible_v<T> && alignof(T) <= Scratch::alignment);

 public:
  using value_type = T;
  Borrowed() = default;
  Borrowed(Borrowed&& other) noexcept { swap(other); }
  Borrowed& operator=(Borrowed&& other) noexcept {
    give_back();
    swap(other);
    return *this;
  }
  ~Borrowed() { give_back(); }

  void give_back() {
    if (scratch_ != nullptr) scratch_->give_back(data_, size_ * sizeof(T));
    scratch_ = nullptr;
    data_ = nullptr;
    size_ = 0;
  }
  /// Gives back all but the first n values.
  void shrink(std::size_t n) {
    if (n >= size_) return;
    scratch_->give_back_end(data_, size_ * sizeof(T), n * sizeof(T));
    size_ = n;
  }
  /// Sets all values, using all threads.
  void fill(const T& value) {
    constexpr LocalId part_size = 8192;
    for_each_part({0, static_cast<LocalId>(size_)}, part_size,
                  [&](Range part) { std::fill(data_ + part.begin, data_ + part.end, value); });
  }

  T* data() const { return data_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T& operator[](std::size_t i) const { return data_[i]; }
  T* begin() const { return data_; }
  T* end() const { return data_ + size_; }
  void swap(Borrowed& other) {
    std::swap(scratch_, other.scratch_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
  }

 private:
  friend class Scratch;
  Borrowed(Scratch& scratch, std::size_t n, bool briefly)
      : scratch_(&scratch), data_(static_cast<T*>(scratch.take(n * sizeof(T), briefly))), size_(n) {}

  Scratch* scratch_ = nullptr;
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace trevi
