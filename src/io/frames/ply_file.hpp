// Whether a PLY file contains what its header says. VTK's reader trusts the header, and reads beyond its memory if that
// is wrong.
#pragma once

#include <string>

namespace trevi {

/// Whether a word is a number as a whole, which is then stored in `value`; zero bytes, as from a hole in a file, are
/// not.
bool is_number(const std::string& word, double& value);

/// InputError, with the line if there is one, unless a file consists of vertices (with x, y, z) and then faces (with a
/// list of up to 255 corners), as text with one element per line or as bytes in either order, with every number
/// complete.
void check_ply(const std::string& path);

}  // namespace trevi
