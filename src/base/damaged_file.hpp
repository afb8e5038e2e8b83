// The one kind of invalid input for which another copy of the same file may help.
#pragma once

#include "trevi/error.hpp"

namespace trevi {

/// A file that does not contain what was once written to it.
class DamagedFile : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace trevi
