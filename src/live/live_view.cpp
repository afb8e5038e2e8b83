#include "live/live_view.hpp"

#include <chrono>
#include <thread>

#include "io/frames/visible.hpp"
#include "parallel/collective.hpp"
#include "parallel/reductions.hpp"

namespace trevi {

namespace {

constexpr int signal_interval = 50;  // ms between rank 0's looks at signals while the run is held
constexpr auto test_interval = std::chrono::milliseconds(2);  // between the other ranks' looks for orders

// Blocking collectives spin, which a held run must not do for hours.
void finish_collective(MPI_Request& request, bool asleep) {
  if (!asleep) {
    MPI_Wait(&request, MPI_STATUS_IGNORE);
    return;
  }
  for (int done = 0; MPI_Test(&request, &done, MPI_STATUS_IGNORE) == MPI_SUCCESS && done == 0;)
    std::this_thread::sleep_for(test_interval);
}

/// The particles of all ranks on rank 0, in rank order.
void gather(MPI_Comm comm, const std::vector<ViewedParticle>& mine, ViewedFrame& frame) {
  const int size = size_of(comm), count = static_cast<int>(mine.size());
  std::vector<int> counts(static_cast<std::size_t>(size)), starts(counts.size());
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  std::size_t total = 0;
  for (std::size_t r = 0; r < counts.size(); ++r) {
    starts[r] = static_cast<int>(total);
    total += static_cast<std::size_t>(counts[r]);
  }
  if (rank_of(comm) == 0) {
    frame.rank_counts.assign(counts.begin(), counts.end());
    frame.shown.resize(total);
  }
  MPI_Datatype particle = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(sizeof(ViewedParticle), MPI_BYTE, &particle);
  MPI_Type_commit(&particle);
  MPI_Gatherv(mine.data(), count, particle, frame.shown.data(), counts.data(), starts.data(), particle, 0, comm);
  MPI_Type_free(&particle);
}

}  // namespace

LiveView::LiveView(MPI_Comm comm, LiveViewOptions options) : comm_(comm), options_(std::move(options)) {
  on_root(comm_, [&] {
    if (options_.link) options_.link->introduce(options_.scene);
  });
  if (options_.link) options_.link->greet();
}

void LiveView::observe(const Frame& frame) {
  bool held = false;
  do {
    const Orders orders = agree(frame.clock.step, held);
    density_ = orders.density != 0;
    if (orders.frame != 0) send(frame, orders.budget);
    held = orders.hold != 0;
  } while (held);
}

void LiveView::finish(const Frame& frame) {
  over_ = true;
  const Orders orders = agree(frame.clock.step, false);
  if (orders.frame != 0) send(frame, orders.budget);
  if (options_.link) options_.link->end("the run has ended");
}

LiveView::Orders LiveView::agree(std::int64_t step, bool held) {
  Orders orders;
  if (options_.link) {
    if (!held) options_.link->wait(0);
    orders = held ? decide_when_held(step) : decide(step);
    if (orders.frame != 0) sent_ = step;
  }
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibcast(&orders, sizeof(Orders) / sizeof(std::int64_t), MPI_INT64_T, 0, comm_, &request);
  finish_collective(request, held);
  return orders;
}

LiveView::Orders LiveView::decide_when_held(std::int64_t step) {
  for (;;) {
    options_.link->wait(signal_interval);
    const Orders orders = decide(step);
    if (orders.hold == 0 || orders.frame != 0) return orders;
  }
}

LiveView::Orders LiveView::decide(std::int64_t step) {
  ViewerLink& link = *options_.link;
  if (link.changed()) sent_ = -1, single_steps_ = 0;
  const ViewerWishes& wishes = link.wishes();
  Orders orders;
  orders.hold = to_be_held() ? 1 : 0;
  const bool credit = sent_ < 0 || wishes.seen == sent_ || over_;
  orders.frame = link.has_viewer() && credit && sent_ != step ? 1 : 0;
  orders.density = wishes.density ? 1 : 0;
  orders.budget = wishes.budget;
  return orders;
}

// Called repeatedly while the run is held; each single step that was asked for is granted once.
bool LiveView::to_be_held() {
  const ViewerWishes& wishes = options_.link->wishes();
  const bool leave = over_ || wishes.stop || (options_.requests && stop_reason(options_.requests()));
  if (!wishes.paused || leave) {
    single_steps_ = wishes.single_steps;
    return false;
  }
  if (wishes.single_steps <= single_steps_) return true;
  ++single_steps_;
  return false;
}

void LiveView::send(const Frame& frame, std::int64_t budget) {
  ViewedFrame sent;
  sent.step = frame.clock.step;
  sent.time = frame.clock.time();
  sent.particles = sum_over_ranks(comm_, frame.particles.size());
  sent.fountains.assign(frame.fountains.begin(), frame.fountains.end());
  gather(comm_, pick_visible(frame, budget, sent.level), sent);
  if (options_.link) options_.link->send(sent);
}

std::vector<ViewedParticle> LiveView::pick_visible(const Frame& frame, std::int64_t budget, int& level) const {
  const Particles& particles = frame.particles;
  VisibleCells cells({options_.scene.min, options_.scene.max}, options_.cell);
  for (const Vec3& p : particles.position) cells.mark(p);
  const auto marks = cells.marks();
  MPI_Allreduce(MPI_IN_PLACE, marks.data(), static_cast<int>(marks.size()), MPI_UINT8_T, MPI_BOR, comm_);
  cells.find_hidden();
  std::vector<LocalId> visible;
  visible.reserve(particles.id.size());
  for (LocalId i = 0; i < particles.size(); ++i) {
    if (!cells.hidden(particles.position[static_cast<std::size_t>(i)])) visible.push_back(i);
  }
  level = thinning_level(sum_over_ranks(comm_, static_cast<std::int64_t>(visible.size())), budget);
  std::vector<ViewedParticle> picked;
  picked.reserve(visible.size() >> level);
  for (const LocalId i : visible) {
    const auto k = static_cast<std::size_t>(i);
    if (!drawn_at(particles.id[k], level)) continue;
    const Eigen::Vector3f p = particles.position[k].cast<float>();
    ViewedParticle particle{p.x(), p.y(), p.z(), static_cast<float>(particles.velocity[k].norm())};
    if (!frame.density.empty()) particle.density = static_cast<float>(frame.density[k]);
    const Rgb rgb = colour_of(options_.colour, particles, i);
    std::copy(rgb.begin(), rgb.end(), particle.rgb);
    picked.push_back(particle);
  }
  return picked;
}

std::unique_ptr<Observer> make_live_view(MPI_Comm comm, LiveViewOptions options) {
  return std::make_unique<LiveView>(comm, std::move(options));
}

}  // namespace trevi
