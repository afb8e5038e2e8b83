// What connects a viewer with its run: a random key that both have, and nobody else. It is stored in the run's folder,
// readable by its owner only; whichever side comes first creates it, and a restart keeps it. A viewer that starts a run
// itself passes the key on in the environment (TREVI_VIEW_KEY), which also serves two machines that share no files.
// ZeroMQ's CURVE lets nothing through to a side whose caller has another key, and encrypts everything else. Rank-local.
#pragma once

#include <string>

namespace trevi {

inline constexpr const char *viewer_key_variable = "TREVI_VIEW_KEY", *viewer_key_file = "view.key";

struct ViewerKey {
  std::string secret, open;  ///< 40 characters each; the open one can be computed from the secret one
};

ViewerKey new_viewer_key();

/// The key of the environment, or of the folder, which is created with a new key if there is none. InputError if it
/// cannot be created, is not a key, or could be known to others.
ViewerKey viewer_key_of(const std::string& directory);

}  // namespace trevi
