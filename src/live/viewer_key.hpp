// What ties a viewer to its run: a random key that both have, and nobody else. It lies in the run's folder, readable by
// its owner only; whichever end comes first makes it, and a restart keeps it. A viewer that starts a run itself hands
// it on in the environment (TREVI_VIEW_KEY), which also serves two machines that share no files. ZeroMQ's CURVE lets
// nothing through to an end whose caller has another key, and encrypts what it lets through. Rank-local.
#pragma once

#include <string>

namespace trevi {

inline constexpr const char *viewer_key_variable = "TREVI_VIEW_KEY", *viewer_key_file = "view.key";

struct ViewerKey {
  std::string secret, open;  ///< 40 characters each; who knows the secret one can work out the open one
};

ViewerKey new_viewer_key();

/// That of the environment, or of the folder, which is made with a new key when there is none. InputError when it
/// cannot be made, is no key, or could be known to others.
ViewerKey viewer_key_of(const std::string& directory);

}  // namespace trevi
