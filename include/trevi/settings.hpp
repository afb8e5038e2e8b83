// What a solver is to do, in SI units and with the names of the scene file (inputs/README.md). Plain data: a program or
// the scene reader fills it, resolved() sets the defaults that depend on other settings, and make_solver() builds from
// it, fountains, inlets, drains and the writers of files included. Where a value stays std::nullopt, or a list empty,
// the feature is absent, and nothing is built for it.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "trevi/body.hpp"
#include "trevi/box.hpp"
#include "trevi/clock.hpp"
#include "trevi/colour.hpp"
#include "trevi/obstacle.hpp"
#include "trevi/types.hpp"

namespace trevi {

/// A setting whose default follows from other settings: it has no value until it is assigned, by hand or by resolved().
template <class T>
class Derived {
 public:
  Derived() = default;
  template <std::convertible_to<T> U>
  requires(!std::same_as<U, Derived>) Derived(const U& value) : value_(T(value)) {}
  /// Has no effect where a value was assigned before.
  void set_default(const T& value) { value_ = value_.value_or(value); }
  bool given() const { return value_.has_value(); }
  T value() const { return value_.value(); }  ///< std::bad_optional_access without one
  operator T() const { return value(); }
  bool operator==(const Derived&) const = default;
  template <std::convertible_to<T> U>
  requires(!std::same_as<U, Derived>) bool operator==(const U& other) const { return value_ == T(other); }

 private:
  std::optional<T> value_;
};

enum class Mass { calibrated, volume };
enum class Method { jacobi, chebyshev, anderson };
enum class Constraint { equality, inequality };
enum class Precision { single, double_ };
enum class VorticityForm { report, projected };
enum class WallDensity { none, analytic };
enum class Reflection { normal, report };
enum class MusicKind { score, midi, sound, live };
enum class Follow { pitch, loudness };
enum class SpeedMapping { linear, energy };

/// kernel_radius over spacing: with less a particle has hardly a neighbour, with more thousands.
inline constexpr Real min_kernel_ratio = 1.2, largest_kernel_ratio = 4;

struct FluidSettings {
  Real spacing = 0.1;             ///< of the start lattice, m
  Real rest_density = 1000;       ///< kg/m³
  Derived<Real> kernel_radius{};  ///< h, m; default 2 spacing
  Mass mass = Mass::calibrated;
  std::string density_kernel = "spiky";  ///< of rho, by its name
  /// Kernel along whose gradient particles are shifted; default: the density kernel, or Spiky for Poly6.
  Derived<std::string> gradient_kernel{};
  /// 2: a layer of particles in the plane y = 0, with kernels normalised there; the domain is one spacing thick then,
  /// and what stands in it goes on along y (in_two_dimensions.hpp).
  int dimensions = 3;
  bool operator==(const FluidSettings&) const = default;
};

struct DensitySettings {
  Method method = Method::chebyshev;
  Derived<int> iterations{};      ///< the coarse-grid correction counts as one; default: 3 with it, else 4
  std::optional<Real> tolerance;  ///< stop when mean compression is below it and the maximum below ten times it
  Derived<Real> relaxation{};     ///< under-relaxation; default: a fraction of what the kernel's lattice allows
  Real spectral_radius = 0.95;    ///< chebyshev: spectral radius assumed of the relaxed Jacobi iteration
  Derived<bool> coarse_grid{};    ///< long-range part of the correction on the cell grid; default: with chebyshev
  Derived<Real> max_shift{};      ///< cap on what a pair is pushed apart in an iteration, in units of h; 0: none
  Real epsilon = 1;               ///< 1/m² at spacing 0.1
  Constraint constraint = Constraint::inequality;
  Precision precision = Precision::double_;
  Real crush_limit =
      0.05;  ///< mean compression from which on the water is crushed, which a run tells; over 0.5 it ends
  bool operator==(const DensitySettings&) const = default;
};

struct WallSettings {
  Real restitution = 0.5;
  WallDensity density = WallDensity::analytic;
  Reflection reflection = Reflection::normal;
  Real floor_friction = 0;  ///< skin friction coefficient c_f of the floor; 0: none
  bool operator==(const WallSettings&) const = default;
};

struct TensileSettings {
  Real k = 0.001;  ///< m² at spacing 0.1
  int n = 4;
  Real dq = 0.2;  ///< in units of h
  bool operator==(const TensileSettings&) const = default;
};

struct MusicSettings {
  std::string source;                        ///< a file, or "-" for raw PCM on standard input
  Derived<MusicKind> kind{};                 ///< default: by the ending of source
  Derived<Follow> follow{};                  ///< what sets the speed; default: loudness of a sound, pitch of a score
  int track = 0, channel = 0;                ///< of a MIDI file, from 1; 0: all (but channel 10, the drums)
  int rate = 44100;                          ///< of raw PCM, Hz
  std::pair<Real, Real> speed_range{5, 10};  ///< m/s, for the lowest and highest note, or silence and the loudest
  SpeedMapping mapping = SpeedMapping::linear;
  bool operator==(const MusicSettings&) const = default;
};

/// What drives a fountain or an inlet.
struct PumpSettings {
  Vec3 direction = Vec3::UnitZ();  ///< of any length but zero
  Real speed = 10, jitter = 0;     ///< m/s; speed counts where there is no music
  Real start = 0, stop = 1e300;    ///< s
  std::optional<MusicSettings> music;

  /// The highest speed without jitter, m/s.
  Real top_speed() const { return music ? music->speed_range.second : speed; }

  bool operator==(const PumpSettings&) const = default;
};

struct FountainSettings : PumpSettings {
  Real center[2] = {0, 0};             ///< m, on the floor
  Real diameter = 0.15, height = 0.2;  ///< m, upright cylinder on the floor

  bool operator==(const FountainSettings&) const = default;
};

/// Speed of the water along an opening, m/s, of height z, m, and time t, s. Equal where the texts are.
struct SpeedProfile {
  std::string text;
  std::function<Real(Real z, Real t)> speed;

  bool operator==(const SpeedProfile& other) const { return text == other.text; }
};

enum class InletShape { disc, rectangle };

/// An opening through which water enters along `direction`.
struct InletSettings : PumpSettings {
  InletShape shape = InletShape::disc;
  Vec3 center = Vec3::Zero();  ///< m
  Real radius = 0;             ///< m, disc
  Real size[2] = {0, 0};       ///< m, rectangle: level, and across that
  std::optional<Real> flow;    ///< m³/s, in place of the speed
  bool recycle = false;        ///< it gives back what drains have taken, and nothing else
  /// In place of the speed: of an opening in an upright wall of the box that deep water enters by. With a level its
  /// shape counts.
  std::optional<SpeedProfile> profile;
  std::optional<Real> level;  ///< m: it is held before such an opening, by more or less water

  /// Whether it is an opening in a wall that deep water enters by.
  bool is_in_wall() const { return profile || level; }

  bool operator==(const InletSettings&) const = default;
};

enum class DrainShape { box, cylinder, plane };

/// A region that water leaves the scene by.
struct DrainSettings {
  DrainShape shape = DrainShape::box;
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();  ///< m, box
  Vec3 center = Vec3::Zero();                   ///< m; cylinder: of its base; plane: a point of it
  Vec3 axis = Vec3::UnitZ();                    ///< of any length; plane: its normal, to the side that is drained
  Real radius = 0, height = 0;                  ///< m, cylinder
  /// Of a box at an upright wall of the box through which the water in it leaves such that it has this level, m, or
  /// that so much leaves, m³/s; at most one of them.
  std::optional<Real> level, flow;

  /// Whether water leaves by the wall behind it, rather than by the region.
  bool is_in_wall() const { return level || flow; }

  bool operator==(const DrainSettings&) const = default;
};

/// A box of water that comes to rest, so that no waves come back from the wall behind it.
struct DampingSettings {
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();  ///< m
  Real rate = 0;  ///< 1/s, at its end; from 0 at its beginning, with the square of the way
  /// Of length 1, along x or y, to the end; by default to the nearest wall across the box.
  Derived<Vec3> direction{};

  bool operator==(const DampingSettings&) const = default;
};

enum class GaugeKind { height, pressure, velocity, pressure_in_water, flow, run_up };

/// A place where the water is measured. It changes nothing.
struct GaugeSettings {
  GaugeKind kind = GaugeKind::height;
  Vec3 center = Vec3::Zero();  ///< m; height: the foot of the column; pressure: on a wall or an obstacle; others: there
  /// Normalised. Pressure: out of the solid; flow: the way that counts as positive; run-up: level, the way up the
  /// beach.
  Vec3 normal = Vec3::UnitZ();
  /// m, of the disc around the centre over which the mean is taken; velocity: of the ball; run-up: half the width of
  /// the strip.
  Real radius = 0;
  Real size[2] = {0, 0};  ///< m, of the rectangle of a flow: the level edge, and across that

  bool operator==(const GaugeSettings&) const = default;
};

/// [output.vtu] and [output.vtkhdf]: frames for ParaView.
struct FrameSettings {
  Schedule schedule;
  std::vector<std::string> fields = {"velocity", "density", "id"};

  bool operator==(const FrameSettings&) const = default;
};

enum class FrameFormat { vtkhdf, vtu };
enum class FrameContent { particles, cells };

/// One of [[output.frames]]: frames of its own schedule in a folder of its own, of all particles or of a selection that
/// does not depend on the ranks, or of means over the cells of the coarse grid, which are one kernel radius wide.
struct FrameSetSettings {
  std::string name;  ///< its folder is frames_NAME; empty: its number in the scene, from 0
  FrameContent what = FrameContent::particles;
  FrameFormat format = FrameFormat::vtkhdf;  ///< cells: vtkhdf
  Schedule schedule;
  /// Default: velocity, density and id of particles, fraction and velocity of cells.
  std::optional<std::vector<std::string>> fields;
  Precision precision = Precision::double_;  ///< of the points; other fields are single
  std::int64_t one_in = 1;                   ///< a power of two: so many times fewer, by a hash of the id
  bool surface = false;                      ///< only what lies less than about two kernel radii below the surface
  std::optional<Box> box;                    ///< m: particles in it, its upper faces left out; or its cells

  bool operator==(const FrameSetSettings&) const = default;
};

struct CheckpointSettings {
  Schedule schedule;  ///< may be never: then the start and the end only
  int keep = 2;

  bool operator==(const CheckpointSettings&) const = default;
};

/// The files of a run (postprocess/README.md).
struct OutputSettings {
  std::string directory;  ///< relative to the working directory; empty: make_solver() writes no file
  std::optional<FrameSettings> vtu, vtkhdf;
  std::vector<FrameSetSettings> frames;
  std::optional<CheckpointSettings> checkpoint;
  std::optional<Schedule> series;  ///< of series.csv and obstacles.csv
  std::optional<Schedule> gauges;  ///< of gauges.csv; that of the series where it is absent

  bool operator==(const OutputSettings&) const = default;
};

/// How planes are shared among ranks: by work, as evenly as whole planes allow, throughout the run; or the same number
/// of planes each.
enum class SlabCuts { balanced, equal };

struct Settings {
  Box domain;                      ///< m
  std::array<bool, 3> periodic{};  ///< whether the box repeats along x, y, z, and has no walls there
  Derived<int> slab_axis{};        ///< 0 x, 1 y; default the longer one
  SlabCuts slabs = SlabCuts::balanced;
  /// Slabs, and ranks that share each of them; none: a slab for each rank.
  std::optional<std::array<int, 2>> ranks;
  bool ranks_by_model = false;  ///< in place of `ranks` the shape whose step a model expects to be the shortest
  FluidSettings fluid;
  Real dt = 1.0 / 60;           ///< s
  Derived<Real> cfl{};          ///< splits steps; 0: never; default 2 with chebyshev, 0.2 without gravity, else 0
  int max_substeps = 500;       ///< of a step; one that would need more ends the run
  std::optional<Vec3> gravity;  ///< m/s²
  DensitySettings density;
  WallSettings walls;
  std::vector<ObstacleSettings> obstacles;  ///< the paddles of wavemakers (paddle_of()) among them
  std::vector<BodySettings> bodies;         ///< that move freely
  std::vector<FountainSettings> fountains;
  std::vector<InletSettings> inlets;
  std::vector<DrainSettings> drains;
  std::vector<DampingSettings> dampings;
  std::vector<GaugeSettings> gauges;  ///< those of pressure on a solid and of run-up need an obstacle or a body
  std::optional<TensileSettings> tensile;
  std::optional<Real> vorticity;  ///< epsilon of vorticity confinement
  VorticityForm vorticity_form = VorticityForm::report;
  std::optional<Real> viscosity;  ///< c of XSPH, m³/kg, a fraction per step
  /// Kinematic viscosity nu, m²/s, also by XSPH, so that at most one of the two may be given. The CFL rule splits steps
  /// longer than longest_viscous_step(); where cfl is 0 the scene reader refuses them.
  std::optional<Real> kinematic_viscosity;
  bool no_slip = false;  ///< walls and obstacles hold the water that touches them; with a kinematic viscosity
  OutputSettings output;
  std::optional<Colour> colour;  ///< what "rgb" of the frames shows
  std::uint64_t seed = 1;        ///< of the jitter of fountains and inlets

  bool operator==(const Settings&) const = default;
};

/// Whether anything solid is in the box, or around it: obstacles or bodies.
inline bool has_solids(const Settings& settings) { return !settings.obstacles.empty() || !settings.bodies.empty(); }
/// The obstacles, then the bodies as they are at the start: their numbers among solids.
inline std::vector<ObstacleSettings> solids_of(const Settings& settings) {
  std::vector<ObstacleSettings> all = settings.obstacles;
  all.insert(all.end(), settings.bodies.begin(), settings.bodies.end());
  return all;
}

/// The same settings with a value for every Derived one. Not collective; the same bits on any rank.
Settings resolved(Settings settings);

/// The settings of density.preset = "report" (inputs/README.md, The report's preset): plain Jacobi, no walls in the
/// density, every filter on. Domain, spacing, dt and gravity are left to the caller.
Settings report_settings();

}  // namespace trevi
