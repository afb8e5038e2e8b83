// The constants of the projection, all of them, each with its unit, its meaning and the study that chose it. Times are
// in units of sqrt(h/g), in which water falls by half of h.
#pragma once

#include "trevi/types.hpp"

namespace trevi::projection {

// ---- particles to grid
// ------------------------------------------------------------------------------------------------

/// Weight of a neighbour cell, along each axis, in the affine fit of a cell (affine.hpp). With 1/2 closed water that
/// turns once loses 0.2 % of its angular momentum at R = 10 s and 1/60 s, with 1/4 and 0.15 nothing measurable; water
/// in vessels rested half as well with 0.15 as with 1/2, when cut cells were not yet exact.
constexpr Real tent = 0.25;
/// Added to the variance of positions in a fit, cells²: particles in a plane or on a line have no gradient across it.
constexpr Real fit_damping = 1e-3;
/// Water in a cell and around it, over that in full cells, below which the particles of a fit are few; and what is
/// added to the variance of their positions besides, cells², where there is none and the fit closes the cell. Two to
/// four that meet within a part of a cell say little of its faces: told to close all of it as fast, they were thrown
/// out at its top. 51 drops of 2 to 4 m/s on slabs gain 0.27 J in the mean for 2.8 without this and without the bound
/// of sheets at cut solids.
constexpr Real few = 0.375, few_damping = 0.2;
/// The same for few particles, beside no solid, that lie almost in a plane, on a line or in a point, whatever they do:
/// what is added, cells², where the inverse of the sum of the inverses of the variances of their places along the
/// principal axes is below half of flat_variance, cells². Places that hardly differ tell a slope that is wrong by any
/// factor, and faces lie ten times as far away: what they asked for threw the particles, which then differed more. Of
/// 60 blocks of 8 to 200 particles in a box (postprocess/study_little_water.py) 20 gained more than 0.05, up to 5.4, of
/// their energy at 1/960 s, and 0.19 in the mean; now 7, 0.23 and 0.020. Others gain 0.008 in the mean, with a damping
/// of 0.02 and 0.1 0.010 and 0.006, but with 0.1 a thin jet spreads; without a condition on the variance 0.009, but
/// motion that is linear is not exact; at solids, too, sheets on 45 degrees keep 0.75 of their momentum for 0.87.
constexpr Real flat_variance = 0.03, flat_damping = 0.05;
/// The same at solids, where fits that open a cell get it, too: what they say is extrapolated to slivers in which no
/// particle is, and which answered by a pressure that fed them. Sheets of one layer on slopes of 5 to 60 degrees gained
/// up to 133 and 550 times their energy at 1/960 and 1/1920 s so. With 0.375 sheets on 10 degrees gain three times
/// theirs at 1/960 s, with 0.5 0.04. In cells beside no solid the dam would swell by 0.03 % of its volume.
constexpr Real few_at_solid = 0.5;
/// A particle's motion is seen midway of its predicted path, but at most this far from the end, and pressure acts at
/// its beginning, but at most twice as far; its volume is where it began, but at most `max_path` from the end along
/// each axis, back on its path, cells. Cut off along each axis for itself, the place of volume left the path, and water
/// in a cylinder of R = 20 s lost 4.1 % of its angular momentum in a turn at 1/60 s for 1.9 %. With 0.5 jets rise too
/// high. With 0.4 a cylinder of R = 20 s that is full to its wall gains 9 % in ten turns at 1/60 s, for 12 that it
/// loses, and the dam keeps 0.924 of its energy for 0.914, but is 0.225 % too thin for 0.201, waves of 0.3 of the depth
/// gain 2.6 % for 1.7, and a plane jet on a plate keeps less than 0.95 of its speed; with 0.3 0.947 for 0.951.
constexpr Real max_half_path = 0.5, max_path = 0.25;
/// Least weight, particles, of the linear mean at a face; with less there is hardly any water, and the fits themselves
/// say how the face moves.
constexpr Real min_face_weight = 0.05;

// ---- free surface
// -----------------------------------------------------------------------------------------------------

/// Fraction of its volume that a cell must hold to count as wet. At the surface 0.585: the water then stands at least a
/// twelfth of a cell above the cell's middle, where phi is given. It is not 0.6, as this is what the top layer of a
/// lattice fills at h = 2.5 spacings: rounding would make some of its cells wet and others dry, and a pool at rest
/// would move at 0.1 m/s. Below the surface the fraction is lower, as cells of disordered water may hold only a third;
/// on the floor lower still, so that a sheet of one layer is supported, too.
constexpr Real wet_fill = 0.585, submerged_fill = 0.3, floor_fill = 0.2;
/// Share by which a cell without particles may be told more than those on one side of it can tell, and is air all the
/// same: rounding where their layers lie on its face.
constexpr Real told_rounding = 1e-3;
/// Largest volume, cells, by which the fill of the cells below may raise or lower the surface in a top cell. The cells
/// of torn water, and those at the side of a jet, are far from full, and say nothing of its height: what a cell has too
/// much or too little counts in full up to `torn`, cells, and not at all from twice that on. A jet on a plate has 0.96
/// of the speed of its head at the opening so for 0.90 (s = 0.025 m, 1/240 s). Not so beside solids, where water that
/// turns lost 1 % a turn.
constexpr Real max_excess = 0.25, torn = 0.1;
/// Largest difference, of itself, between the capacities of cells of a column that are cut alike; most by which what
/// they hold may differ from what is around them in the level of the top one; share of their excess that counts there.
/// The paraboloid of a cylinder of R = 10 s, from a lattice, is 1.06 times as steep as that of the start's rotation
/// with half of it, 1.09 with three quarters, 1.12 with all (1/240 s).
constexpr Real alike = 0.02, max_uneven = 0.5, excess_of_cut = 0.5;
/// Least distance, cells, of the middle of a cut cell from the mean place of its water, from which on its level is
/// continued to there; most of the difference to the cell beside that it takes for that: with 0.3, 0.5, 0.8, 1.2 the
/// same paraboloid from rings is 1.115, 1.085, 1.060, 1.055, but with 0.8 water at R = 20 s gains 5 to 9 % of its
/// angular momentum in five turns.
constexpr Real min_aside = 0.05, max_continued = 0.5;
/// Least height of the surface above the middle of a top cell, cells: a bound on the ghost-fluid weight.
constexpr Real min_height = 0.05;
/// Least rise of the surface, cells, from a dry cell to the wet one beside it, by which that is pressed: a dry cell may
/// be filled up to above its middle, and where both stand alike nothing does. A bound on the same weight.
constexpr Real min_rise = 1e-6;
/// Least weight of the particles of a wet cell at a face in the side of water, over that in full water: a bound on how
/// far the pressure displaces them (README.md). With 0.15, 0.2, 0.3 a block of 4³ particles that collapses gains up to
/// 10, 5.8, 4.4 % of the energy of its start again when it is a sheet, 0.1 % where all weigh as full water.
constexpr Real min_side = 0.3;
/// Fraction of its volume in particles of which the middle is in it from which on a cell counts for the depth, and from
/// which on it has a surface of water in or above it. A sheet on a solid may be as thin as one on the floor.
constexpr Real deep_fill = 0.2, surface_fill = 0.4;
/// A cell of which less is open follows the cell beyond its widest face: what it holds of water says hardly anything.
constexpr Real small_cell = 0.2;
/// The same at upright sides of solids that are driven, from which particles lag by a part of a cell: waves by a piston
/// are 0.95 of theory with 0.2 there, 0.965 with 0.5. Water that turns along a wall at rest keeps less with 0.5
/// (README.md), and a box that is lowered into water takes 22 % too much work for 16.
constexpr Real small_cell_at_driven = 0.5;

// ---- pressure
// ---------------------------------------------------------------------------------------------------------

/// Fill of a cell below which its water is thin, and from which on down it weighs as much as it fills: the pressure
/// between such cells moves less water, and moves it further. If all weighed as full ones, the sides of a jet that
/// meets a pool, a third full, would give it three times what they lose: at 5 m/s, falling 1.4 m, it gains 5, 123, 298
/// J of 2.3 kJ at 1/60, 1/240, 1/480 s so, and 0, 6, 2 J with these values (s = 0.05 m). With 0.95 and 0.8 in their
/// place 0, 2, 1 J, but a plane jet on a plate keeps 0.93 of the speed of its head for 0.96 (s = 0.025 m, 1/240 s), and
/// where every cell weighs what it fills high waves gain 5 to 10 % of their energy.
constexpr Real thin_begins = 0.8, thin_full = 0.6;
/// V-cycles from the hydrostatic start. Two give the same waves, pools and columns as a converged solution, three the
/// same compression of a falling cube.
constexpr int cycles = 3;
/// The same of water that has no surface, which has no such start.
constexpr int closed_cycles = 6;
/// How often bodies that move freely answer to the pressure, and the cycles after each answer. From the second answer
/// on they are settled where what the motion of each still lacks, by its own mass, is no more than that part of h in
/// the substep. A raft, a ball and a torus afloat need two answers in 111 of 120 steps, a box of a twentieth of the
/// water's density on its way up two to four, one of a fiftieth three to five. With two alone the speed of the first
/// jumps by 0.8 m/s from step to step, that of the second by 5 m/s.
constexpr int min_coupling_iterations = 2, max_coupling_iterations = 8, cycles_per_answer = 1;
constexpr Real coupling_tolerance = 0.01;
/// Time in which a cell returns to its volume, sqrt(h/g); without gravity the distance its water travels, cells.
constexpr Real return_time = 6;
/// A cell that a solid cuts returns that much as fast as others: what it holds is noisier, and water in a box turned
/// about three axes rests three times as well so. At 0.1 it stays a quarter of a spacing too high.
constexpr Real cut_return = 0.5;

// ---- grid to particles
// ------------------------------------------------------------------------------------------------

/// Time in which the motion within cells that is not smooth dies away, sqrt(h/g). What is smooth is not touched: affine
/// motion by nothing, a wave of wavelength L by (h/L)^4. Measured: shear of 7 h keeps 0.95 of its energy in a turn
/// with 3.5 and 0.98 with 14; a pool that starts with each coordinate off by up to 0.2 s rests at 6e-6 and 5e-5 m²/s².
constexpr Real noise_time = 12;
/// Where a solid cuts a cell the motion relaxes to the affine one itself, this many times as fast: there faces and
/// particles are few, and noise is made. Whatever the motion, turned tanks swing 3.2, 2.9, 2.7 % off the plain box at
/// most with 45, 38, 30, and vessels rest at 6.2e-5, 6.9e-5 m²/s² deep and 1.4e-4, 1.7e-4 shallow in the median with 45
/// and 38.
constexpr Real cut_noise = 38;
/// Relaxation of a cut cell is slower by r/(r + this), r being the mean square of what its fit leaves over the square
/// of its mean motion: of a wave a fit leaves its curvature, which is no noise. With 0.002, 0.005, 0.01, 0.02 a tank
/// turned by 20 degrees swings up to 3.5, 3.2, 2.8, 2.8 % off the plain box at 1/60 s, one by 35 degrees on the floor
/// of the box 4.6, 3.7, 3.2, 2.8 %; with 0.01 and 0.02 vessels rest at 1.6e-4, 1.8e-4 m²/s² deep and 3.5e-4, 4.7e-4
/// shallow in the median. At bodies that float it is not slower. The motion is that past the box: water in a vessel
/// that is carried along keeps its noise for longer.
constexpr Real smooth_rest = 0.01;
/// From the surface downwards as many cells at solids that move in the water; below, only the filter of all cells acts:
/// what curves about such a solid is no noise. A ball of 3 and 5 spacings on a spring under water, 1/60 s, keeps 0.91
/// and 0.96 of its swing in half a period, of an ideal period 1.014 and 1.020, with 4 0.79 and 0.96, to all depths 0.44
/// and 0.77, 1.206 and 1.050. At all solids water that turns in a cylinder of R = 20 s would gain 0.7 of its angular
/// momentum in five turns.
constexpr int cut_noise_cells = 3;
/// Speed, sqrt(g h): what moves faster than this relative to its cell is a jet rather than noise, and is damped the
/// less the faster it moves. Without this bound a jet through a pool lost a sixth of its height.
constexpr Real noise_speed = 0.2;
/// Spacings below the surface: the correction acts in full up to a quarter of a spacing below the surface, and fades
/// out over the next two spacings above that. A wave 3 spacings high loses 1.0 % of its amplitude a period where it
/// acts in full up to a quarter above, 0.4 % so, and gains 0.5 % where it fades from half a spacing below.
constexpr Real fade_begins = 0.25, fade_length = 2;
/// Displacement by pressure in the middle of a cell, over that which bears weight, from which on, and at which in full,
/// it is pulled back to where paths begin (README.md); in cells that solids cut, but bodies, where it is not smooth,
/// all of it: water that turns at R = 20 s would gain 0.6 of its angular momentum in five turns. The pressure in waves
/// is that of their surface, which is where paths begin already: with all of it pulled back waves of 0.3 of the depth
/// gain 5.5 % of their own energy at 1/60 s for 1.4 %. Without gravity none is: vortices at Re 1000 and 20 across have
/// 0.94 of the energy that they should have at three quarters with it, and 0.97 without.
constexpr Real pulled_begins = 1.5, pulled_full = 2.5;
/// Least and largest portion that each particle of a face takes of what its displacement has beyond those around
/// (face_shares.hpp): full water over the water that is there. Shear at 45° from a lattice, 20 across, 1/200 s, keeps
/// 0.983 of its energy in a turn so, and 0.959 where all take as much; with 0.56 and 5 it keeps the same.
constexpr Real min_portion = 2.0 / 3, max_portion = 2;
/// Area of the solid surface in a cell, faces, from which on it has a direction.
constexpr Real min_wall = 0.1;
/// Least distance, cells, of a solid's surface from the open face opposite to a closed one, for the continuation to the
/// latter. With 1, none, water in a cylinder of R = 10 s keeps 0.92 of its angular momentum in ten closed turns at
/// 1/60 s and 0.76 in ten open ones, with 0.5 0.97 and 0.84, with 0.3 1.00 and 0.91; upwards, too, shallow water in
/// vessels rests four times as badly.
constexpr Real min_distance = 0.3;

// ---- shifts of positions
// ----------------------------------------------------------------------------------------------

/// Mean compression of the particles around from which on, and at which in full, sweeps may push water apart over more
/// than a cell. Relaxed water has 0.004 by itself, as its kernel sums exceed those of the lattice of the same density.
constexpr Real swelling_begins = 0.004, swelling_full = 0.008;
/// Compression of a particle from which on, and at which in full, its own shift is left as it is. Flowing water has a
/// spread of 0.01; what exceeds that twice over is a particle that is squeezed, at a wall most of all.
constexpr Real squeezed_begins = 0.02, squeezed_full = 0.04;
/// Part of what shifts within a cell would give to its affine motion that they do not give. They push apart what is too
/// near, so that by the slope of the cell alone shear gains by them, up to 3 % in three turns at 45° from a lattice
/// (20 across, 1/400 s); by curvature it loses as much, which the slope of a cell does not see. With all of it not
/// given vortices at Re 1000, 20 across, have 0.91 of the energy that they should have after 3 s, with half 0.93, as
/// without.
constexpr Real withheld = 0.5;

}  // namespace trevi::projection
