// libFuzzer target: scenes and overrides. The input is a scene, then overrides, each after a NUL. Whatever it is, the
// answer is a scene or an InputError; and a scene compared with itself has no changes. Built with TREVI_FUZZ.
#include <cstdlib>
#include <string>
#include <vector>

#include "scene/scene_changes.hpp"
#include "trevi/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  std::vector<std::string> parts = {""};
  for (std::size_t k = 0; k < size; ++k) {
    if (data[k] == 0)
      parts.emplace_back();
    else
      parts.back() += static_cast<char>(data[k]);
  }
  const std::string text = parts.front();
  parts.erase(parts.begin());
  try {
    const trevi::Scene scene = trevi::parse_scene("fuzz.toml", text, parts);
    const trevi::CheckpointInfo info{scene.text, "", 1, scene.overrides};
    if (!trevi::scene_changes(info, "fuzz.h5", scene, {}).empty() || scene.steps() < 0) std::abort();
  } catch (const trevi::InputError&) {
  }
  return 0;
}
