// Particles spread over ranks in any way, brought into the order of their ids: rank r ends with one contiguous range of
// ids and of rows, and no rank ever holds an array of global size. Method: local sort, splitters found by bisection
// over the id range (one MPI_Allreduce of P − 1 counts a round, at most 64), one all-to-all. Ids need not be dense;
// equal ids meet on one rank, where they can be found. Collective: constructor and apply.
#pragma once

#include <span>
#include <vector>

#include "trevi/session.hpp"
#include "trevi/types.hpp"

namespace trevi {

class IdOrder {
 public:
  /// Every rank but the last non-empty one gets the same number of rows, a multiple of `block` (unless ids repeat).
  IdOrder(MPI_Comm comm, std::span<const GlobalId> ids, GlobalId block = 1);

  GlobalId total() const { return total_; }                  ///< rows over all ranks
  GlobalId first_row() const { return first_row_; }          ///< of this rank's range
  const std::vector<GlobalId>& ids() const { return ids_; }  ///< of this rank's range, ascending

  /// One field in the order of ids(): field.size() is that of the constructor's ids. T is trivially copyable or Eigen
  /// fixed.
  template <class T>
  std::vector<T> apply(const std::vector<T>& field) const;

 private:
  std::vector<GlobalId> find_splitters(std::span<const GlobalId> sorted, GlobalId block);
  void plan_exchange(std::span<const GlobalId> sorted, std::span<const GlobalId> splitters);
  void exchange(const void* sent, void* received, std::size_t bytes_per_row) const;

  MPI_Comm comm_;
  GlobalId total_ = 0, first_row_ = 0;
  std::vector<GlobalId> ids_;
  std::vector<LocalId> send_order_, receive_order_;
  bool arrives_sorted_ = true;  // then there is no receive_order_
  std::vector<int> send_counts_, send_starts_, receive_counts_, receive_starts_;
};

template <class T>
std::vector<T> IdOrder::apply(const std::vector<T>& field) const {
  std::vector<T> buffer(send_order_.size());
  for (std::size_t k = 0; k < buffer.size(); ++k) buffer[k] = field[static_cast<std::size_t>(send_order_[k])];
  if (size_of(comm_) == 1) return buffer;
  std::vector<T> received(ids_.size());
  exchange(buffer.data(), received.data(), sizeof(T));
  if (arrives_sorted_) return received;
  buffer.resize(received.size());
  for (std::size_t k = 0; k < buffer.size(); ++k) buffer[k] = received[static_cast<std::size_t>(receive_order_[k])];
  return buffer;
}

}  // namespace trevi
