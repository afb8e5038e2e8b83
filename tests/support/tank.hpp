// The tables with which the scenes of tests begin, as text: a box, water in blocks of it, the time step.
#pragma once

#include <string>
#include <vector>

namespace trevi::test {

/// What differs from one tank to the next. Corners are texts, "0, 0, 0".
struct Tank {
  struct Block {
    std::string min, max, more = {};  ///< more keys, lines of their own
  };
  std::string min = "0, 0, 0", max;
  std::vector<Block> water = {};
  std::string dt = "0.0166666666666666667", end = "1";  ///< s
  std::string spacing = "0.1";                          ///< m
  std::string domain = {}, fluid = {}, time = {};       ///< more keys of these tables
};

/// The last table is [time].
inline std::string tank_text(const Tank& tank) {
  const auto line = [](const std::string& keys) { return keys.empty() ? keys : keys + "\n"; };
  std::string text = "[domain]\nmin = [" + tank.min + "]\nmax = [" + tank.max + "]\n" + line(tank.domain) +
                     "[fluid]\nspacing = " + tank.spacing + "\n" + line(tank.fluid);
  for (const Tank::Block& block : tank.water)
    text += "[[particles]]\nmin = [" + block.min + "]\nmax = [" + block.max + "]\n" + line(block.more);
  return text + "[time]\ndt = " + tank.dt + "\nend = " + tank.end + "\n" + line(tank.time);
}

/// The same with gravity; the last table is [gravity].
inline std::string tank_with_gravity(const Tank& tank) { return tank_text(tank) + "[gravity]\n"; }

}  // namespace trevi::test
