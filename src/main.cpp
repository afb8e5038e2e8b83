#include "trevi/app/run.hpp"

int main(int argc, char** argv) {
  const trevi::Session session(argc, argv);
  try {
    return static_cast<int>(trevi::run(session, argc, argv));
  } catch (const trevi::Error& error) {
    return trevi::report_error(session, error);
  } catch (const std::exception& error) {  // out of memory, for instance
    return trevi::report_error(session, trevi::RunError(error.what()));
  }
}
