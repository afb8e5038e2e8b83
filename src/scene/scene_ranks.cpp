#include "scene/scene_ranks.hpp"

#include <cmath>

#include "scene/scene_place.hpp"

namespace trevi {

namespace {

constexpr SceneKey ranks_key("domain", "ranks"), box_key("domain", "max"), method_key("density", "method");

}  // namespace

void read_ranks(Section& domain, Scene& scene) {
  const Key key{
      "ranks",
      "slabs, and ranks that share each of them, or \"auto\" for what a model of the run says; default a slab "
      "for each rank"};
  box_key.add(scene, domain.line_of("max"));
  ranks_key.add(scene, domain.line_of("ranks"));
  const toml::node* node = domain.find(key, "2 numbers or \"auto\"");
  if (node == nullptr) return;
  scene.ranks_by_model = node->value<std::string>() == "auto";
  if (scene.ranks_by_model) return;
  const toml::array* given = node->as_array();
  std::array<int, 2> ranks{};
  bool fine = given != nullptr && given->size() == 2;
  for (std::size_t k = 0; fine && k < 2; ++k) {
    const Real number = (*given)[k].value<Real>().value_or(0);
    fine = number >= 1 && number <= 1e9 && number == std::floor(number);
    if (fine) ranks[k] = static_cast<int>(number);
  }
  if (!fine) return domain.refuse(key, "must be two whole numbers from 1 to 1e9, or \"auto\"");
  scene.ranks = ranks;
}

Slabs slabs_of(MPI_Comm comm, const Scene& scene, const CellGrid& grid, const CellWeights& weights) {
  told_at(scene, method_key, [&] { check_unknowns(scene, weights.planes); });
  const bool shaped = scene.ranks || scene.ranks_by_model;
  return told_at(scene, shaped ? ranks_key : box_key, [&] { return first_slabs(comm, scene, grid, weights); });
}

}  // namespace trevi
