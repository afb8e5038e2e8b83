#include "base/version.hpp"

namespace trevi {

const char* trevi_version() { return TREVI_VERSION; }

}  // namespace trevi
