// Runs GoogleTest under mpirun: every rank runs every test, rank 0 reports, the others only what fails on them.
// The exit code is the maximum over ranks. TREVI_TEST_INSTRUCTION_SET names the instruction set of the pair loops,
// "AVX2" for instance, in place of the best.
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <memory>

#include "base/simd.hpp"
#include "trevi/session.hpp"

namespace {

/// Prints failures with the rank they happened on.
class FailurePrinter : public testing::EmptyTestEventListener {
 public:
  explicit FailurePrinter(int rank) : rank_(rank) {}

  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (!result.failed()) return;
    const char* file = result.file_name() != nullptr ? result.file_name() : "unknown";
    std::cerr << "rank " << rank_ << ": " << file << ":" << result.line_number() << ": " << result.summary()
              << std::endl;
  }

 private:
  int rank_;
};

void silence_all_but_failures(int rank) {
  testing::TestEventListeners& listeners = testing::UnitTest::GetInstance()->listeners();
  // One report file, too: ranks that write the same XML would spoil it.
  std::unique_ptr<testing::TestEventListener> printer(listeners.Release(listeners.default_result_printer()));
  std::unique_ptr<testing::TestEventListener> report(listeners.Release(listeners.default_xml_generator()));
  listeners.Append(new FailurePrinter(rank));  // GoogleTest takes ownership
}

bool instruction_set_as_asked() {
  const char* name = std::getenv("TREVI_TEST_INSTRUCTION_SET");
  return name == nullptr || *name == '\0' || trevi::use_instruction_set(name);
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const trevi::Session session(argc, argv);
  if (session.rank() != 0) silence_all_but_failures(session.rank());
  if (!instruction_set_as_asked()) {
    std::cerr << "TREVI_TEST_INSTRUCTION_SET: this machine has no such instruction set" << std::endl;
    return 1;
  }
  int code = RUN_ALL_TESTS();
  MPI_Allreduce(MPI_IN_PLACE, &code, 1, MPI_INT, MPI_MAX, session.comm());
  return code;
}
