#include "domain/send_to_owners.hpp"

#include <numeric>

#include "base/growth.hpp"
#include "base/threads.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {

std::vector<int> starts_of(const std::vector<int>& counts) {
  std::vector<int> starts(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  return starts;
}

/// Number of particles for each rank, and where they begin among all that are sent or received.
struct Counts {
  explicit Counts(std::vector<int> of_ranks) : counts(std::move(of_ranks)), starts(starts_of(counts)) {}
  std::size_t total() const { return static_cast<std::size_t>(starts.back() + counts.back()); }
  std::vector<int> counts, starts;
};

std::vector<int> count_leaving(std::span<const int> owners, int rank, int ranks) {
  std::vector<int> counts(static_cast<std::size_t>(ranks));
  for (const int owner : owners)
    if (owner != rank) ++counts[static_cast<std::size_t>(owner)];
  return counts;
}

std::vector<int> swap_counts(MPI_Comm comm, const std::vector<int>& sent) {
  std::vector<int> received(sent.size());
  MPI_Alltoall(sent.data(), 1, MPI_INT, received.data(), 1, MPI_INT, comm);
  return received;
}

// The particles that leave, by owner, those of each owner in their order.
std::vector<LocalId> leaving_by_owner(std::span<const int> owners, int rank, const Counts& sent) {
  std::vector<LocalId> leaving(sent.total());
  std::vector<int> next = sent.starts;
  for (std::size_t i = 0; i < owners.size(); ++i) {
    if (owners[i] == rank) continue;
    leaving[static_cast<std::size_t>(next[static_cast<std::size_t>(owners[i])]++)] = static_cast<LocalId>(i);
  }
  return leaving;
}

template <class T>
std::vector<T> chosen_rows(const std::vector<T>& field, const std::vector<LocalId>& chosen) {
  std::vector<T> rows(chosen.size());
  for_each_index({0, static_cast<LocalId>(rows.size())},
                 [to = rows.data(), from = field.data(), chosen = chosen.data()](std::size_t k) {
                   to[k] = from[static_cast<std::size_t>(chosen[k])];
                 });
  return rows;
}

template <class T>
void keep_own(std::vector<T>& field, std::span<const int> owners, int rank) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < owners.size(); ++i)
    if (owners[i] == rank) field[kept++] = field[i];
  field.resize(kept);
}

template <class T>
void exchange(MPI_Comm comm, const std::vector<T>& rows, const Counts& sent, const Counts& received,
              std::vector<T>& field) {
  const std::size_t stay = field.size();
  resize_tightly(field, stay + received.total());
  MPI_Datatype row;
  MPI_Type_contiguous(sizeof(T), MPI_BYTE, &row);
  MPI_Type_commit(&row);
  MPI_Alltoallv(rows.data(), sent.counts.data(), sent.starts.data(), row, field.data() + stay, received.counts.data(),
                received.starts.data(), row, comm);
  MPI_Type_free(&row);
}

}  // namespace

GlobalId send_to_owners(MPI_Comm comm, Particles& particles, std::span<const int> owners) {
  const int rank = rank_of(comm);
  const Counts sent(count_leaving(owners, rank, size_of(comm)));
  const Counts received(swap_counts(comm, sent.counts));
  const std::vector<LocalId> leaving = leaving_by_owner(owners, rank, sent);
  particles.for_each_field([&](auto& field) {
    const auto rows = chosen_rows(field, leaving);
    keep_own(field, owners, rank);
    exchange(comm, rows, sent, received, field);
  });
  return static_cast<GlobalId>(leaving.size());
}

}  // namespace trevi
