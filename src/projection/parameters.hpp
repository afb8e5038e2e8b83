// The constants of the projection, all of them, each with its unit, its meaning and the study that chose it. Times are
// in units of sqrt(h/g), in which water falls by half of h.
#pragma once

#include "trevi/types.hpp"

namespace trevi::projection {

// ---- particles to grid -----------------------------------------------------------------------------------------

/// Weight of a neighbouring cell, along each axis, in the affine fit of a cell (affine.hpp). With 1/2, enclosed water
/// loses 0.2 % of its angular momentum in one turn at R = 10 s and 1/60 s, with 1/4 and 0.15 nothing measurable. Water
/// in vessels rested half as well with 0.15 as with 1/2 when cut cells were not yet exact.
constexpr Real tent = 0.25;
/// Added to the variance of positions in a fit, cells²: particles in a plane or on a line have no gradient across it.
constexpr Real fit_damping = 1e-3;
/// Fill of a cell and the cells around it, over that of full cells, below which the particles of a fit are few; and the
/// further addition to the variance of their positions, cells², at zero fill where the fit closes the cell. Two to four
/// particles that meet within a part of a cell say little about its faces: when the fit closed the whole cell as fast,
/// they were thrown out at its top. 51 drops of 2 to 4 m/s on slabs gain 0.27 J on average, and 2.8 without this and
/// without the bound on sheets at cut solids.
constexpr Real few = 0.375, few_damping = 0.2;
/// The same for few particles, not beside a solid, that lie almost in a plane, on a line or in a point, whatever their
/// motion: the addition, cells², where the inverse of the sum of the inverse variances of their positions along the
/// principal axes is below half of flat_variance, cells². Positions that hardly differ give a slope that may be wrong
/// by any factor, and faces lie ten times as far away: the displacements that followed threw the particles, which then
/// differed more. Of 60 blocks of 8 to 200 particles in a box (postprocess/study_little_water.py) 20 gained more than
/// 0.05, up to 5.4, of their energy at 1/960 s, and 0.19 on average; now 7, 0.23 and 0.020. Others gain 0.008 on
/// average; with a damping of 0.02 and 0.1 they gain 0.010 and 0.006, but with 0.1 a thin jet spreads. Without a
/// condition on the variance it is 0.009, but linear motion is not exact. If it is applied at solids, too, sheets on 45
/// degrees keep 0.75 of their momentum instead of 0.87.
constexpr Real flat_variance = 0.03, flat_damping = 0.05;
/// The same at solids, where it also applies to fits that open a cell. These are extrapolated to slivers that hold no
/// particles and that responded with a pressure which amplified them. Sheets of one layer on slopes of 5 to 60 degrees
/// thus gained up to 133 and 550 times their energy at 1/960 and 1/1920 s. With 0.375 sheets on 10 degrees gain three
/// times theirs at 1/960 s, with 0.5 0.04. In cells that are not beside a solid it would make the dam swell by 0.03 %
/// of its volume.
constexpr Real few_at_solid = 0.5;
/// The motion of a particle is evaluated at the midpoint of its predicted path, but at most this far from the end along
/// each axis, cells; under gravity its volume is placed there, too, and the mean path of a cell counts up to twice
/// this. Without gravity pressure acts at the beginning of a path, but at most twice this far from its end.
constexpr Real max_half_path = 0.5;
/// Without gravity the volume of a particle is placed where its path began, but at most this far from the end along
/// each axis, back on the path, cells, and displacements are moved back across their direction by at most this. Cut off
/// separately along each axis, the volume would leave the path.
constexpr Real max_path = 0.25;
/// Smallest weight, in particles, of the linear mean at a face. With less there is hardly any water, and the fits
/// themselves determine the motion of the face.
constexpr Real min_face_weight = 0.05;

// ---- free surface ----------------------------------------------------------------------------------------------

/// Fill from which on a cell counts as wet. At the surface it is 0.585: the water then reaches at least a twelfth of a
/// cell above the centre of the cell, where phi is given. It is not 0.6, because the top layer of a lattice fills as
/// much at h = 2.5 spacings: rounding would make some of its cells wet and others dry, and a pool at rest would move at
/// 0.1 m/s. Below the surface the fill is lower, because cells of disordered water may hold only a third. On the floor
/// it is lower still, so that a sheet of one layer is supported, too.
constexpr Real wet_fill = 0.585, submerged_fill = 0.3, floor_fill = 0.2;
/// Relative excess over the largest fill that particles on one side of a cell can give it, up to which a cell without
/// particles is still air: the rounding where their layers lie on its face.
constexpr Real told_rounding = 1e-3;
/// Largest volume, cells, by which the fill of the cells below may raise or lower the surface in a top cell. The cells
/// of torn water, and those at the side of a jet, are far from full and say nothing about its height: the excess or
/// deficit of a cell counts in full up to `torn`, cells, and not at all from twice that on. A jet on a plate thus has
/// 0.96 of the speed of its head at the opening instead of 0.90 (s = 0.025 m, 1/240 s). This does not apply beside
/// solids, where rotating water lost 1 % per turn.
constexpr Real max_excess = 0.25, torn = 0.1;
/// Largest relative difference between the capacities of cells of a column that are cut alike; largest difference
/// between their fill and that around them that enters the level of the top cell; and the share of their excess that
/// counts there. The paraboloid of a cylinder of R = 10 s, from a lattice, is 1.06 times as steep as that of the
/// initial rotation with half of the excess, 1.09 with three quarters, 1.12 with all (1/240 s).
constexpr Real alike = 0.02, max_uneven = 0.5, excess_of_cut = 0.5;
/// Largest half of the rise of a surface in a step, cells, by which it is lowered to where paths begin: faster ones
/// belong to jets and impacts. With 0.12, 0.25 and 0.5 a plane jet of 8 spacings on a plate keeps 0.942, 0.965, 0.968
/// of its speed at 1/60 s (s = 0.025 m, max_change_across = 0.5, max_fade_shift = 0).
constexpr Real max_half_rise = 0.25;
/// The same half in cells that solids other than bodies cut, over that of the motion of their water, in whose fits few
/// particles on one side of a wall take part. With 1, 1.1, 1.15 and 1.3 swings in tanks turned by 20 and 35 degrees
/// differ by up to 3.8, 2.7, 2.4, 2.1 % from those in the plain box at 1/60 s, by up to 3.5, 3.3, 3.1, 2.8 % at 1/240
/// s. With 1.3 they gain at 1/60 s.
constexpr Real rise_of_cut = 1.15;
/// Smallest distance, cells, of the centre of a cut cell from the mean position of its water, from which on its level
/// is extrapolated to the centre; and the largest part of the difference to the neighbouring cell that is used for
/// this. With 0.3, 0.5, 0.8, 1.2 the same paraboloid from rings is 1.115, 1.085, 1.060, 1.055, but with 0.8 water at R
/// = 20 s gains 5 to 9 % of its angular momentum in five turns.
constexpr Real min_aside = 0.05, max_continued = 0.5;
/// Smallest height of the surface above the centre of a top cell, cells: a bound on the ghost-fluid weight.
constexpr Real min_height = 0.05;
/// Smallest rise of the surface, cells, from a dry cell to the wet cell beside it with which the latter is under
/// pressure. A dry cell may be filled to above its centre, and where both levels are equal there is no pressure. A
/// bound on the same weight.
constexpr Real min_rise = 1e-6;
/// Smallest weight of the particles of a wet cell at a face in the side of water, over that in full water: a bound on
/// their displacement by the pressure (README.md). With 0.15, 0.2, 0.3 a collapsing block of 4³ particles gains up to
/// 10, 5.8, 4.4 % of its initial energy when it has become a sheet, and 0.1 % if all weigh as much as full water.
constexpr Real min_side = 0.3;
/// Fill up to which a cell beside air, or one that a solid cuts, takes in water that arrives; and what of it is not
/// taken in, over what the weight brings in a step to a cell whose floor is closed: at solids at rest twice as much,
/// because shallow water in a gentle hill simmers otherwise. A ball of 400 kg/m³ and 2.4 spacings radius, which a cube
/// of water meets at 2 m/s, gets 1.52, 1.56, 1.54 m/s at 1/60, 1/240, 1/960 s (2.09, 3.11, 3.91 without; the ball that
/// flies into the water 1.33 to 1.36). With 0.85, 0.88, 0.9, 0.92 the dam break is 0.21, 0.20, 0.20, 0.18 % too thin
/// and has 0.934, 0.935, 0.935, 0.930 of its energy after 1 s (0.25 % and 0.925 without).
constexpr Real full_enough = 0.9, by_weight = 1.05, by_weight_at_rest = 2;
/// Fill of a cell, by particles whose centre is in it, from which on it counts for the depth, and from which on it has
/// a free surface in or above it. A sheet on a solid may be as thin as one on the floor.
constexpr Real deep_fill = 0.2, surface_fill = 0.4;
/// A cell with a smaller open fraction follows the cell beyond its widest face, because its fill says hardly anything.
constexpr Real small_cell = 0.2;
/// The same at vertical sides of solids with a prescribed motion, behind which particles lag by a part of a cell: waves
/// of a piston are 0.95 of theory with 0.2 there, and 0.965 with 0.5. Water that rotates along a wall at rest keeps
/// less angular momentum with 0.5 (README.md), and lowering a box into water takes 22 % too much work instead of 16.
constexpr Real small_cell_at_driven = 0.5;

// ---- pressure --------------------------------------------------------------------------------------------------

/// Fill of a cell below which its water is thin, and fill below which its mass is in proportion to the fill: the
/// pressure between such cells moves less water, and moves it further. If all cells weighed as much as full ones, the
/// sides of a jet that meets a pool, a third full, would give it three times what they lose: at 5 m/s, falling 1.4 m,
/// it then gains 5, 123, 298 J of 2.3 kJ at 1/60, 1/240, 1/480 s, and 0, 6, 2 J with these values (s = 0.05 m). With
/// 0.95 and 0.8 instead it is 0, 2, 1 J, but a plane jet on a plate keeps 0.93 of the speed of its head instead of 0.96
/// (s = 0.025 m, 1/240 s). If the mass of every cell is in proportion to its fill, high waves gain 5 to 10 % of their
/// energy.
constexpr Real thin_begins = 0.8, thin_full = 0.6;
/// V-cycles from the hydrostatic initial guess. Two give the same waves, pools and columns as a converged solution, and
/// three also the same compression of a falling cube.
constexpr int cycles = 3;
/// The same for water without a surface, which has no such initial guess.
constexpr int closed_cycles = 6;
/// How often freely moving bodies respond to the pressure, and the number of cycles after each response. From the
/// second response on they have converged if the residual of the motion of each, by its own mass, is no more than this
/// fraction of h in the substep. A floating raft, ball and torus need two responses in 111 of 120 steps; a rising box
/// of a twentieth of the water's density needs two to four, one of a fiftieth three to five. With only two, the speed
/// of the former jumps by 0.8 m/s from step to step, that of the latter by 5 m/s.
constexpr int min_coupling_iterations = 2, max_coupling_iterations = 8, cycles_per_answer = 1;
constexpr Real coupling_tolerance = 0.01;
/// Time in which a cell returns to its volume, sqrt(h/g); without gravity the distance that its water travels, cells.
constexpr Real return_time = 6;
/// Relative rate at which a cut cell returns to its volume: its fill is noisier, and water in a box rotated about three
/// axes rests three times as well with this. At 0.1 it remains a quarter of a spacing too high.
constexpr Real cut_return = 0.5;

// ---- grid to particles -----------------------------------------------------------------------------------------

/// Decay time of motion within cells that is not smooth, sqrt(h/g). Smooth motion is hardly affected: affine motion not
/// at all, a wave of wavelength L by (h/L)^4. Measured: shear of 7 h keeps 0.95 of its energy in a turn with 3.5 and
/// 0.98 with 14; a pool with initial coordinates perturbed by up to 0.2 s rests at 6e-6 and 5e-5 m²/s².
constexpr Real noise_time = 12;
/// In a cut cell the motion relaxes to the affine fit itself, this many times as fast: faces and particles are few
/// there, and noise is generated. Whatever the motion, swings in rotated tanks differ from those in the plain box by at
/// most 3.2, 2.9, 2.7 % with 45, 38, 30, and vessels rest at 6.2e-5, 6.9e-5 m²/s² if deep and 1.4e-4, 1.7e-4 if
/// shallow, in the median, with 45 and 38.
constexpr Real cut_noise = 38;
/// Relaxation of a cut cell is slower by r/(r + this), where r is the mean square of the residual of its fit over the
/// square of its mean motion: the residual of a wave is its curvature, which is not noise. With 0.002, 0.005, 0.01,
/// 0.02 swings in a tank rotated by 20 degrees differ by up to 3.5, 3.2, 2.8, 2.8 % from those in the plain box at 1/60
/// s, in one rotated by 35 degrees on the floor of the box by 4.6, 3.7, 3.2, 2.8 %. With 0.01 and 0.02 vessels rest
/// at 1.6e-4, 1.8e-4 m²/s² if deep and 3.5e-4, 4.7e-4 if shallow, in the median. At floating bodies it is not slower.
/// The motion is relative to the box: water in a vessel that is carried along keeps its noise for longer.
constexpr Real smooth_rest = 0.01;
/// Number of cells from the surface downwards in which this relaxation acts at solids that move in the water. Below
/// them only the filter of all cells acts, because the curvature of the flow about such a solid is not noise. A ball of
/// 3 and 5 spacings on a spring under water, 1/60 s, keeps 0.91 and 0.96 of its swing in half a period, with periods
/// of 1.014 and 1.020 times the ideal one; with 4 cells 0.79 and 0.96, at all depths 0.44 and 0.77, 1.206 and 1.050.
/// With this limit at all solids, water that rotates in a cylinder of R = 20 s would gain 0.7 of its angular momentum
/// in five turns.
constexpr int cut_noise_cells = 3;
/// Speed, sqrt(g h): a particle that moves faster than this relative to its cell belongs to a jet rather than to noise,
/// and is damped the less the faster it moves. Without this bound a jet through a pool lost a sixth of its height.
constexpr Real noise_speed = 0.2;
/// In spacings below the surface: the correction acts in full on particles that are at least this far below the
/// surface, and fades out over the next two spacings above that. With 0.25, 0.15, 0.05 the dam has 0.924, 0.932, 0.935
/// of its energy after 1 s (1/150 s, max_change_across = 0.5), but with 0.05 and levels midway sheets of one layer on
/// 45 degrees gained up to 3.6 times their energy at 1/960 s.
constexpr Real fade_begins = 0.15, fade_length = 2;
/// For the fade, a particle is in the middle of its path as it would be without gravity, but at most this far above or
/// below its beginning, cells. With 0, 0.1 and 0.25 waves of 0.3 of the depth gain 2.7, 1.9, 1.9 % of their own energy
/// (s = 0.025 m, 1/60 s), a plane jet of 8 spacings on a plate keeps 0.965, 0.968, 0.954 of its speed, and the dam
/// 0.933, 0.932, 0.924 of its energy after 1 s (max_change_across = 0.5).
constexpr Real max_fade_shift = 0.1;
/// Smallest and largest portion that each particle of a face takes of the face's displacement beyond those around
/// (face_shares.hpp): full water over the water present. Shear at 45° from a lattice, 20 across, 1/200 s, thus keeps
/// 0.983 of its energy in a turn, and 0.959 if all take the same; with 0.56 and 5 it keeps as much.
constexpr Real min_portion = 2.0 / 3, max_portion = 2;
/// Shortest mean path of a cell, cells, for which its displacement is moved back across its direction, and the same of
/// a cut cell, where water at rest is noisier: with 1e-3 shallow vessels rest with 1.07 times the energy. And the
/// smallest part of a full cell's particles: of few, differences across cells say little. Eight that lie flat on a
/// floor gain 0.12 of their energy without this; with 0.5 water in a cylinder of R = 10 s keeps 0.982 of its angular
/// momentum in five turns at 1/60 s instead of 0.993.
constexpr Real min_path_across = 1e-3, min_path_across_cut = 1e-2, min_held_across = 0.375;
/// Largest change of the upward displacement from cell to cell with which displacements are moved back across their
/// direction, over the displacement by gravity: in an impact the change is not linear. With 0.5, 1, 2 and no bound the
/// mean compression of a falling cube is 0.46, 0.49, 0.50, 0.55 % at 1/60 s, and a hole of 4 cells in a floor, 1/120 s,
/// has a contraction coefficient of 0.635, 0.625, 0.621, 0.617.
constexpr Real max_change_across = 2;
/// Difference between the open parts of opposite faces of a cell, well below which the surface of a solid does not pass
/// between them, and its place is in the middle. Not tuned.
constexpr Real level_surface = 0.05;
/// Area of the solid surface in a cell, faces, from which on it has a direction.
constexpr Real min_wall = 0.1;
/// Smallest distance, cells, of the surface of a solid from the open face opposite to a closed one, for the
/// extrapolation to the latter. With 1, which means none, water in a cylinder of R = 10 s keeps 0.92 of its angular
/// momentum in ten closed turns at 1/60 s and 0.76 in ten open ones, with 0.5 0.97 and 0.84, with 0.3 1.00 and 0.91.
/// With extrapolation upwards, too, shallow water in vessels rests four times as badly.
constexpr Real min_distance = 0.3;

// ---- shifts of positions ---------------------------------------------------------------------------------------

/// Mean compression of the surrounding particles from which on, and at which in full, sweeps may push water apart over
/// more than a cell. Relaxed water has 0.004 by itself, because its kernel sums exceed those of a lattice of the same
/// density.
constexpr Real swelling_begins = 0.004, swelling_full = 0.008;
/// Compression of a particle from which on, and at which in full, its own shift is left as it is. Flowing water has a
/// spread of 0.01; a particle that exceeds twice that is squeezed, usually at a wall.
constexpr Real squeezed_begins = 0.02, squeezed_full = 0.04;
/// Part of what shifts within a cell would give to its affine motion that is withheld. Shifts push apart particles that
/// are too near, so that with the slope of the cell alone shear gains energy by them, up to 3 % in three turns at 45°
/// from a lattice (20 across, 1/400 s); by curvature, which the slope of a cell does not see, it loses as much. With
/// all of it withheld, vortices at Re 1000, 20 across, have 0.91 of the energy that they should have after 3 s; with
/// half 0.93, as without.
constexpr Real withheld = 0.5;

}  // namespace trevi::projection
