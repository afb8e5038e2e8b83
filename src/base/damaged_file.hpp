// The one kind of bad input that another copy of the same file may do without.
#pragma once

#include "trevi/error.hpp"

namespace trevi {

/// A file that does not hold what was once written to it.
class DamagedFile : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace trevi
