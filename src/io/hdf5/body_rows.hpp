// The states of bodies as numbers in a checkpoint. Not collective.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "io/hdf5/hdf5_reader.hpp"
#include "trevi/body.hpp"

namespace trevi {

/// 67 numbers for each body, in the order of the members of its state.
std::vector<Real> numbers_of(std::span<const BodyState> bodies);
/// The states in /bodies. DamagedFile if they are not valid.
std::vector<BodyState> bodies_of(const std::string& path, const Hdf5Reader& file);

}  // namespace trevi
