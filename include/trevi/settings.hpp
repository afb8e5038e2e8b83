// The settings of a solver, in SI units and with the names of the scene file (inputs/README.md). Plain data: a program
// or the scene reader fills them, resolved() sets the defaults that depend on other settings, and make_solver() builds
// the solver from them, including fountains, inlets, drains and the writers of files. Where a value stays std::nullopt,
// or a list empty, the feature is absent, and nothing is built for it.
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

/// A setting whose default follows from other settings. It has no value until assigned, by hand or by resolved().
template <class T>
class Derived {
 public:
  Derived() = default;
  template <std::convertible_to<T> U>
  requires(!std::same_as<U, Derived>) Derived(const U& value) : value_(T(value)) {}
  /// Has no effect if a value was assigned before.
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

/// Limits of kernel_radius over spacing. Below them a particle has hardly any neighbours, above them it has thousands.
inline constexpr Real min_kernel_ratio = 1.2, largest_kernel_ratio = 4;

struct FluidSettings {
  Real spacing = 0.1;             ///< of the initial lattice, m
  Real rest_density = 1000;       ///< kg/m³
  Derived<Real> kernel_radius{};  ///< h, m; default 2 spacing
  Mass mass = Mass::calibrated;
  std::string density_kernel = "spiky";  ///< name of the kernel of rho
  /// Name of the kernel along whose gradient particles are shifted; default: the density kernel, or Spiky for Poly6.
  Derived<std::string> gradient_kernel{};
  /// In two dimensions the particles form a layer in the plane y = 0, in which the kernels are normalised. The domain
  /// is then one spacing thick, and solids are infinite along y (in_two_dimensions.hpp).
  int dimensions = 3;
  bool operator==(const FluidSettings&) const = default;
};

struct DensitySettings {
  Method method = Method::chebyshev;
  Derived<int> iterations{};      ///< including the coarse-grid correction as one; default: 3 with it, else 4
  std::optional<Real> tolerance;  ///< stop when mean compression is at most this and the maximum ten times this
  Derived<Real> relaxation{};     ///< under-relaxation; default: a fraction of the stability limit of the lattice
  Real spectral_radius = 0.95;    ///< chebyshev: spectral radius assumed of the relaxed Jacobi iteration
  Derived<bool> coarse_grid{};    ///< long-range part of the correction on the cell grid; default: with chebyshev
  Derived<Real> max_shift{};      ///< limit of the shift of a pair in one iteration, in units of h; 0: none
  Real epsilon = 1;               ///< 1/m² at spacing 0.1
  Constraint constraint = Constraint::inequality;
  Precision precision = Precision::double_;
  Real crush_limit = 0.05;  ///< mean compression above which a run reports that the water is crushed; above 0.5 it ends
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
  std::string source;          ///< a file, or "-" for raw PCM on standard input
  Derived<MusicKind> kind{};   ///< default: by the file extension of source
  Derived<Follow> follow{};    ///< what determines the speed; default: loudness of a sound, pitch of a score
  int track = 0, channel = 0;  ///< of a MIDI file, from 1; 0: all (except channel 10, the drums)
  int rate = 44100;            ///< of raw PCM, Hz
  std::pair<Real, Real> speed_range{5, 10};  ///< m/s, for the lowest and highest note, or silence and the loudest sound
  SpeedMapping mapping = SpeedMapping::linear;
  bool operator==(const MusicSettings&) const = default;
};

/// What drives a fountain or an inlet.
struct PumpSettings {
  Vec3 direction = Vec3::UnitZ();  ///< of any nonzero length
  Real speed = 10, jitter = 0;     ///< m/s; speed is used only without music
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

/// Speed of the water along an opening, m/s, as a function of height z, m, and time t, s. Equal if the texts are.
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
  Real size[2] = {0, 0};       ///< m, rectangle: the horizontal edge, and the one perpendicular to it
  std::optional<Real> flow;    ///< m³/s, in place of the speed
  bool recycle = false;        ///< it returns the water that drains have removed, and no other
  /// In place of the speed, for an opening in a vertical wall of the box through which deep water enters. Where a level
  /// is given, only the shape of the profile matters.
  std::optional<SpeedProfile> profile;
  std::optional<Real> level;  ///< m: level that is held in front of such an opening, by more or less inflow

  /// Whether it is an opening in a wall through which deep water enters.
  bool is_in_wall() const { return profile || level; }

  bool operator==(const InletSettings&) const = default;
};

enum class DrainShape { box, cylinder, plane };

/// A region through which water leaves the scene.
struct DrainSettings {
  DrainShape shape = DrainShape::box;
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();  ///< m, box
  Vec3 center = Vec3::Zero();                   ///< m; cylinder: centre of its base; plane: a point on it
  Vec3 axis = Vec3::UnitZ();                    ///< of any length; plane: its normal, towards the drained side
  Real radius = 0, height = 0;                  ///< m, cylinder
  /// For a box at a vertical wall of the domain, through which its water leaves: the level that is held, m, or the flow
  /// that leaves, m³/s; at most one of them.
  std::optional<Real> level, flow;

  /// Whether water leaves through the wall behind the region rather than within it.
  bool is_in_wall() const { return level || flow; }

  bool operator==(const DrainSettings&) const = default;
};

/// A box in which the water is damped, so that no waves are reflected from the wall behind it.
struct DampingSettings {
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();  ///< m
  Real rate = 0;  ///< 1/s, at its end; it grows from 0 at the beginning with the square of the distance
  /// Towards the end, of length 1, along x or y; by default towards the nearest wall across the box.
  Derived<Vec3> direction{};

  bool operator==(const DampingSettings&) const = default;
};

enum class GaugeKind { height, pressure, velocity, pressure_in_water, flow, run_up };

/// A place where the water is measured. It does not affect the water.
struct GaugeSettings {
  GaugeKind kind = GaugeKind::height;
  Vec3 center = Vec3::Zero();  ///< m; height: foot of the column; pressure: on a wall or an obstacle; others: the place
  /// Normalised. Pressure: out of the solid; flow: the direction that counts as positive; run-up: horizontal, the
  /// direction up the beach.
  Vec3 normal = Vec3::UnitZ();
  /// Radius, m, of the disc around the centre over which the mean is taken; velocity: that of the ball; run-up: half
  /// the width of the strip.
  Real radius = 0;
  Real size[2] = {0, 0};  ///< m, rectangle of a flow: the horizontal edge, and the one perpendicular to it

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

/// One of [[output.frames]]: frames with a schedule and a folder of their own. They hold all particles, a selection
/// that does not depend on the ranks, or means over the cells of the coarse grid, which are one kernel radius wide.
struct FrameSetSettings {
  std::string name;  ///< its folder is frames_NAME; empty: its number in the scene, from 0
  FrameContent what = FrameContent::particles;
  FrameFormat format = FrameFormat::vtkhdf;  ///< cells: vtkhdf
  Schedule schedule;
  /// Default: velocity, density and id of particles, fraction and velocity of cells.
  std::optional<std::vector<std::string>> fields;
  Precision precision = Precision::double_;  ///< of the points; other fields are single
  std::int64_t one_in = 1;                   ///< a power of two: one particle in so many, by a hash of the id
  bool surface = false;                      ///< only particles less than about two kernel radii below the surface
  std::optional<Box> box;                    ///< m: particles in it, its upper faces excluded; or its cells

  bool operator==(const FrameSetSettings&) const = default;
};

struct CheckpointSettings {
  Schedule schedule;  ///< may be never: then only at the start and the end
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
  std::optional<Schedule> gauges;  ///< of gauges.csv; if absent, that of the series

  bool operator==(const OutputSettings&) const = default;
};

/// How planes are distributed among ranks: by work, as evenly as whole planes allow and throughout the run, or the same
/// number of planes for each rank.
enum class SlabCuts { balanced, equal };

struct Settings {
  Box domain;                      ///< m
  std::array<bool, 3> periodic{};  ///< whether the box repeats along x, y, z, and has no walls there
  Derived<int> slab_axis{};        ///< 0 x, 1 y; default the longer one
  SlabCuts slabs = SlabCuts::balanced;
  /// Number of slabs, and of ranks that share each of them; none: one slab per rank.
  std::optional<std::array<int, 2>> ranks;
  bool ranks_by_model = false;  ///< in place of `ranks`: the shape with the shortest step according to a model
  FluidSettings fluid;
  Real dt = 1.0 / 60;           ///< s
  Derived<Real> cfl{};          ///< splits steps; 0: never; default 2 with chebyshev, 0.2 without gravity, else 0
  int max_substeps = 500;       ///< of a step; a step that would need more ends the run
  std::optional<Vec3> gravity;  ///< m/s²
  DensitySettings density;
  WallSettings walls;
  std::vector<ObstacleSettings> obstacles;  ///< including the paddles of wavemakers (paddle_of())
  std::vector<BodySettings> bodies;         ///< that move freely
  std::vector<FountainSettings> fountains;
  std::vector<InletSettings> inlets;
  std::vector<DrainSettings> drains;
  std::vector<DampingSettings> dampings;
  std::vector<GaugeSettings> gauges;  ///< pressure on a solid and run-up need an obstacle or a body
  std::optional<TensileSettings> tensile;
  std::optional<Real> vorticity;  ///< epsilon of vorticity confinement
  VorticityForm vorticity_form = VorticityForm::report;
  std::optional<Real> viscosity;  ///< c of XSPH, m³/kg, a fraction per step
  /// Kinematic viscosity nu, m²/s, also by XSPH, so that at most one of the two may be given. The CFL rule splits steps
  /// longer than longest_viscous_step(); if cfl is 0, the scene reader refuses such steps.
  std::optional<Real> kinematic_viscosity;
  bool no_slip = false;  ///< no-slip condition at walls and obstacles; with a kinematic viscosity
  OutputSettings output;
  std::optional<Colour> colour;  ///< what "rgb" of the frames shows
  std::uint64_t seed = 1;        ///< of the jitter of fountains and inlets

  bool operator==(const Settings&) const = default;
};

/// Whether there are any solids, obstacles or bodies, in the box or around it.
inline bool has_solids(const Settings& settings) { return !settings.obstacles.empty() || !settings.bodies.empty(); }
/// The obstacles, followed by the bodies as they are at the start. Solids are numbered in this order.
inline std::vector<ObstacleSettings> solids_of(const Settings& settings) {
  std::vector<ObstacleSettings> all = settings.obstacles;
  all.insert(all.end(), settings.bodies.begin(), settings.bodies.end());
  return all;
}

/// The same settings with a value for every Derived setting. Not collective; the same bits on any rank.
Settings resolved(Settings settings);

/// The settings of density.preset = "report" (inputs/README.md, The report's preset): plain Jacobi iteration, no
/// contribution of walls to the density, all filters on. The caller sets domain, spacing, dt and gravity.
Settings report_settings();

}  // namespace trevi
