// The version of the library, in one source only, or a new one would compile everything.
#pragma once

namespace trevi {

/// "2.0.0"
const char* trevi_version();

}  // namespace trevi
