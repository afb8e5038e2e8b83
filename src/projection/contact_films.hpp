// The pressure between a freely moving body and what it touches. Where a body lies on the floor, on an obstacle or on
// another body, there is no water in a cell between them whose pressure acts on it, as if the contact were sealed:
// light bodies stayed on the floor. Real surfaces leave a film of water between them, which has the pressure of the
// water around the contact.
//
// A uniform pressure on all of a closed surface adds up to nothing. What such a pressure would do to a body in all
// cells around it is therefore the opposite of what it does in its contacts, along each axis by itself: they need no
// description. Where a body touches another one, both have a part of their surface in the contact, which is that of the
// first of them and then no longer missing at the other. Between solids at rest on both sides only the difference of
// the contacts along that axis is known.
//
// What a body displaces in a contact below or above it flows into or out of the cells around it, by the same weights by
// which their pressure is that of the film, so that the film does as much work on the body as on the water. Otherwise a
// light body that rose to a lid gained up to 5.8 kJ in a step as it closed the gap. Beside a body this is left out:
// bodies respond one by one, and nine floats side by side were thrown about. Collective, except displace() and
// record().
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "projection/pressure.hpp"
#include "projection/record_forces.hpp"

namespace trevi {

class ContactFilms {
 public:
  ContactFilms(MPI_Comm comm, const CutCells& cuts, Obstacles& obstacles, Real h);

  /// Finds the contacts of bodies, in cells that have been measured.
  void find(const FreeSurface& surface);
  /// Displaces water by the present twists of the bodies, in the equation of the pressure: to be called after find(),
  /// and whenever the twists have changed.
  void displace(const FreeSurface& surface, Pressure& pressure);
  /// The impulses that the films of the present pressure give to the water, as if it were in contact with all of a
  /// body, about the centres of the bodies; empty if no body touches anything. `spacing` in m.
  const std::vector<TotalImpulse>& press(const FreeSurface& surface, const RecordForces& forces, Real spacing);
  /// Records these for the bodies, and their opposites for the obstacles and the box.
  void record() const;

 private:
  // Of a face: less surface is the rounding of what has been added up.
  static constexpr Real min_contact = 0.01;
  // A side of a body: lower or upper, along one of three directions of the grid.
  static constexpr std::size_t sides = 6;
  static std::size_t side(std::size_t a, bool upper) { return 2 * a + (upper ? 1 : 0); }
  // A part of the surface of a body, along one direction: what a pressure of h² gives to the water there, about the
  // centre of the body, and the same times the square of the height above that, m³.
  struct Open {
    TotalImpulse push{};
    Real square = 0;
  };
  struct Contact {
    std::size_t body, side, other;  // numbers of the body and of a side of it; account of what it touches there
    Open open;                      // of the contact, with the other sign
    TotalImpulse film{};            // what the present pressure gives there
    Real weight = 0;                // of all cells beside this side of the body
    Real displaced = 0;             // volume given to the water so far, in cells
  };
  Real half_height(std::size_t body) const;
  static Real height_of(const Open& open, Eigen::Index b);
  TotalImpulse film_of(const Contact& contact, Eigen::Index b, const TotalImpulse& around, Real g_dt2) const;
  // A cell beside a contact, the number of the side among those of all bodies, the account of what is touched there,
  // and the weight of the cell: what the body closes of one of its faces times the open part of the cell. Slivers
  // beside a body would otherwise count as much as the water next to them.
  struct Beside {
    std::array<LocalId, 3> cell;
    std::size_t side, account;
    Real weight;
  };
  void add_cell(const FreeSurface& surface, const std::array<LocalId, 3>& cell);
  template <class Visit>
  void for_each_touched(const FreeSurface& surface, const std::array<LocalId, 3>& cell, std::size_t body,
                        const Visit& visit) const;
  bool is_at_end_of_gap(const FreeSurface& surface, std::size_t at) const;
  // What touches a side, on all ranks: the weight of the cells beside the contact, in multiples of 2⁻³⁰, and its
  // horizontal moment about the centre of the body, in h.
  struct Touch {
    std::size_t side, account;
    std::int64_t weight;
    std::array<std::int64_t, 2> moment;
  };
  void find_beside(const FreeSurface& surface);
  void find_touches();
  std::span<const Touch> touches_of(std::size_t side) const;
  std::vector<Contact> split(std::size_t body, std::size_t side, const Open& open) const;
  Real displaced_in(const Contact& contact) const;
  void share_out(const FreeSurface& surface, std::vector<Open> missing);
  TotalImpulse about(std::size_t body, const TotalImpulse& push, std::size_t other) const;

  MPI_Comm comm_;
  const CutCells& cuts_;
  Obstacles& obstacles_;
  Real h_;
  ImpulseLedger uniform_, around_;  // for each body and direction; for each body and side
  std::vector<Beside> beside_;
  std::vector<Contact> contacts_;
  std::vector<Touch> touches_;  // by side and account
  std::vector<TotalImpulse> films_;
};

}  // namespace trevi
