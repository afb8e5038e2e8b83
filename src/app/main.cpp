#include <optional>

#include "app/run.hpp"
#include "base/memory.hpp"

int main(int argc, char** argv) {
  const trevi::Mpi mpi(argc, argv);
  std::optional<trevi::Session> session;  // outlives the report of an error, as its end needs all ranks
  try {
    session.emplace(argc, argv);
    return static_cast<int>(trevi::run(*session, argc, argv));
  } catch (const trevi::Error& error) {
    return trevi::report_error(error);
  } catch (const std::exception& error) {  // out of memory, for instance
    return trevi::report_error(trevi::RunError(trevi::text_of(error)));
  }
}
