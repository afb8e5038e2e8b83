#include "parallel/collective.hpp"

#include <exception>
#include <string>

#include "base/damaged_file.hpp"
#include "base/memory.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

struct Failure {
  bool happened = false;
  ExitCode code = ExitCode::run_failed;
  bool damaged = false;  ///< DamagedFile
  std::string message;
};

Failure attempt(const std::function<void()>& work) {
  try {
    work();
    return {};
  } catch (const Error& error) {
    return {true, error.code(), dynamic_cast<const DamagedFile*>(&error) != nullptr, error.what()};
  } catch (const std::exception& error) {
    return {true, ExitCode::run_failed, false, text_of(error)};
  }
}

// The lowest rank where `here` is true; the number of ranks if there is none.
int lowest_rank(MPI_Comm comm, bool here) {
  int rank = here ? rank_of(comm) : size_of(comm);
  MPI_Allreduce(MPI_IN_PLACE, &rank, 1, MPI_INT, MPI_MIN, comm);
  return rank;
}

std::string broadcast(MPI_Comm comm, std::string text, int from) {
  int length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, from, comm);
  text.resize(static_cast<std::size_t>(length));
  MPI_Bcast(text.data(), length, MPI_CHAR, from, comm);
  return text;
}

}  // namespace

void all_or_none(MPI_Comm comm, const std::function<void()>& work) {
  const Failure mine = attempt(work);
  const int size = size_of(comm), culprit = lowest_rank(comm, mine.happened);
  if (culprit == size) return;
  int kind[2] = {static_cast<int>(mine.code), mine.damaged ? 1 : 0};
  MPI_Bcast(kind, 2, MPI_INT, culprit, comm);
  const std::string message = broadcast(comm, mine.message, culprit);
  if (kind[1] != 0) throw DamagedFile(message);
  if (kind[0] == static_cast<int>(ExitCode::bad_input)) throw InputError(message);
  throw RunError(size == 1 ? message : "rank " + std::to_string(culprit) + ": " + message, Reach::all_ranks);
}

void on_root(MPI_Comm comm, const std::function<void()>& work) {
  const bool is_root = rank_of(comm) == 0;
  all_or_none(comm, [&] {
    if (is_root) work();
  });
}

std::string first_text(MPI_Comm comm, const std::string& mine) {
  const int from = lowest_rank(comm, !mine.empty());
  return from == size_of(comm) ? std::string() : broadcast(comm, mine, from);
}

}  // namespace trevi
