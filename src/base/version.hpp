// The version of the library, in one source file only, as a new version would otherwise recompile everything.
#pragma once

namespace trevi {

/// "2.0.0"
const char* trevi_version();

}  // namespace trevi
