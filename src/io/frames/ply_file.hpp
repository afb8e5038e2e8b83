// Whether a PLY file holds what its head says. VTK's reader believes the head, and reads beyond its memory where it is
// wrong.
#pragma once

#include <string>

namespace trevi {

/// Whether all of a word is a number, which then is `value`: bytes of 0, as of a hole in a file, are none.
bool is_number(const std::string& word, double& value);

/// InputError, with the line where there is one, for a file that is not vertices (with x, y, z) and then faces (with a
/// list of up to 255 corners), as text of an element a line or in bytes of either order, each number of it complete.
void check_ply(const std::string& path);

}  // namespace trevi
