// Brings particles that are spread over ranks in any way into the order of their ids: each rank ends with one
// contiguous range of ids and of rows, and no rank ever holds an array of global size. Method: local sort, splitters
// found by bisection over the id range (one MPI_Allreduce of P − 1 counts per round, at most 64), one all-to-all. Ids
// need not be dense; equal ids end up on one rank, where they can be found. Collective: constructor and apply.
#pragma once

#include <span>
#include <vector>

#include "base/threads.hpp"
#include "trevi/session.hpp"
#include "trevi/types.hpp"

namespace trevi {

class IdOrder {
 public:
  /// Every rank except the last non-empty one gets the same number of rows, a multiple of `block` (unless ids repeat).
  IdOrder(MPI_Comm comm, std::span<const GlobalId> ids, GlobalId block = 1);

  GlobalId total() const { return total_; }                  ///< rows over all ranks
  GlobalId first_row() const { return first_row_; }          ///< of this rank's range
  const std::vector<GlobalId>& ids() const { return ids_; }  ///< of this rank's range, ascending

  /// One field in the order of ids(): field.size() is that of the constructor's ids. T is trivially copyable or a
  /// fixed-size Eigen type.
  template <class T>
  std::vector<T> apply(const std::vector<T>& field) const;

 private:
  std::vector<GlobalId> find_splitters(std::span<const GlobalId> sorted, GlobalId block);
  void plan_exchange(std::span<const GlobalId> sorted, std::span<const GlobalId> splitters);
  template <class T>
  static void gather(const std::vector<T>& from, const std::vector<LocalId>& order, std::vector<T>& to);
  void exchange(const void* sent, void* received, std::size_t bytes_per_row) const;

  MPI_Comm comm_;
  GlobalId total_ = 0, first_row_ = 0;
  std::vector<GlobalId> ids_;
  std::vector<LocalId> send_order_, receive_order_;
  bool arrives_sorted_ = true;  // then there is no receive_order_
  std::vector<int> send_counts_, send_starts_, receive_counts_, receive_starts_;
};

template <class T>
void IdOrder::gather(const std::vector<T>& from, const std::vector<LocalId>& order, std::vector<T>& to) {
  for_each_index({0, static_cast<LocalId>(to.size())},
                 [to = to.data(), from = from.data(), order = order.data()](std::size_t k) { to[k] = from[order[k]]; });
}

template <class T>
std::vector<T> IdOrder::apply(const std::vector<T>& field) const {
  std::vector<T> buffer(send_order_.size());
  gather(field, send_order_, buffer);
  if (size_of(comm_) == 1) return buffer;
  std::vector<T> received(ids_.size());
  exchange(buffer.data(), received.data(), sizeof(T));
  if (arrives_sorted_) return received;
  buffer.resize(received.size());
  gather(received, receive_order_, buffer);
  return buffer;
}

}  // namespace trevi
