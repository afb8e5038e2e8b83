// An expression of the coordinates in a scene file, such as "0.1 * sin(pi * x)": muParser's syntax and functions, with
// pi. sin and cos are our own (boundary/geometry/pose.hpp), so that their bits do not depend on the C library; the
// other functions are the library's. One thread at a time. Not collective.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "trevi/types.hpp"

namespace trevi {

class Formula {
 public:
  /// `variables`: "xyz" or "xy". Throws InputError that says what is wrong with the text.
  Formula(const std::string& text, std::string_view variables);
  ~Formula();
  Formula(Formula&&) noexcept;
  Formula& operator=(Formula&&) noexcept;

  /// The value at a position, m. Throws InputError if it is not a finite number.
  Real operator()(const Vec3& place) const;

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

}  // namespace trevi
