// What a watched run does with a viewer that is played by a script: what is sent, when, and how long the run is held.
// The same on any rank count; every rank returns from every call.
#include <set>

#include "io/frames/visible.hpp"
#include "live/live_view.hpp"
#include "support/distributed.hpp"

namespace trevi {
namespace {

using namespace test;

/// Rank 0's end of a line to nobody. `on_wait` plays the viewer; the run calls it whenever it looks at the line.
class ScriptedLink : public ViewerLink {
 public:
  std::function<void(ScriptedLink&)> on_wait = [](ScriptedLink&) {};
  std::vector<ViewedFrame> sent;
  int waits = 0;
  bool ended = false;

  void wait(int) override {
    ++waits;
    on_wait(*this);
  }
  void greet() override {}
  void introduce(const ViewedScene&) override {}
  void send(const ViewedFrame& frame) override { sent.push_back(frame); }
  void end(const std::string&) override { ended = true; }

  void come(const ViewerWishes& wishes) { accept(wishes); }
  void go() { forget(); }
};

class LiveViewTest : public testing::Test {
 protected:
  LiveViewTest() {
    LiveViewOptions options;
    if (rank_of(world) == 0) options.link = link = std::make_shared<ScriptedLink>();
    options.requests = [this] { return requests; };
    options.scene.min = cloud_box.min;
    options.scene.max = cloud_box.max;
    options.colour.by = Colour::rainbow_id;
    view.emplace(world, options);
    particles = particles_of(cloud);
  }

  void observe(std::int64_t step) {
    const Clock clock{step, 0.1, 1};
    view->observe({clock, particles, {}, nullptr, {}});
  }

  std::size_t frames_sent() const { return link->sent.size(); }

  std::shared_ptr<ScriptedLink> link;  // rank 0 only
  RequestCounts requests{};
  std::optional<LiveView> view;
  Cloud cloud = random_cloud(4000, cloud_box, 1);
  Particles particles;
};

TEST_F(LiveViewTest, SendsWhatCanBeSeenOnAnyRankCount) {
  if (link) link->come({.budget = 1 << 20});
  observe(0);
  if (!link) return;
  VisibleCells cells(cloud_box, 0.2);
  for (const Vec3& p : cloud.position) cells.mark(p);
  cells.find_hidden();
  std::multiset<std::array<float, 4>> expected, sent;
  for (std::size_t i = 0; i < cloud.id.size(); ++i) {
    const Vec3& p = cloud.position[i];
    const std::array row{static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()),
                         static_cast<float>(cloud.velocity[i].norm())};
    if (!cells.hidden(p)) expected.insert(row);
  }
  ASSERT_EQ(frames_sent(), 1U);
  for (const ViewedParticle& p : link->sent[0].shown) sent.insert({p.x, p.y, p.z, p.speed});
  EXPECT_EQ(sent, expected);
  EXPECT_LT(sent.size(), cloud.id.size());
  EXPECT_EQ(link->sent[0].particles, 4000);
  EXPECT_EQ(link->sent[0].rank_counts.size(), static_cast<std::size_t>(size_of(world)));
}

TEST_F(LiveViewTest, ThinsToTheBudget) {
  if (link) link->come({.budget = 500});
  observe(0);
  if (!link) return;
  ASSERT_EQ(frames_sent(), 1U);
  EXPECT_GT(link->sent[0].level, 0);
  EXPECT_NEAR(static_cast<double>(link->sent[0].shown.size()), 350, 200);
}

TEST_F(LiveViewTest, FramesAreOnCredit) {
  observe(0);  // nobody there
  if (link) link->come({.budget = 10});
  observe(1);
  observe(2);  // 1 has not been seen yet
  observe(3);
  if (link) link->come({.seen = 1, .budget = 10});
  observe(4);
  if (link) link->go();
  observe(5);
  if (link) link->come({.budget = 10});  // another one
  observe(6);
  if (!link) return;
  ASSERT_EQ(frames_sent(), 3U);
  EXPECT_EQ(link->sent[0].step, 1);
  EXPECT_EQ(link->sent[1].step, 4);
  EXPECT_EQ(link->sent[2].step, 6);
}

TEST_F(LiveViewTest, APauseLastsUntilItIsLifted) {
  if (link) {
    link->come({.paused = true, .budget = 10});
    link->on_wait = [](ScriptedLink& line) {
      if (line.waits == 8) line.come({.paused = true, .single_steps = 2, .budget = 10});
    };
  }
  observe(0);
  if (link) {
    EXPECT_EQ(link->waits, 8);
  }
  observe(1);  // the second of the two steps
  if (link) {
    EXPECT_EQ(link->waits, 9);
    link->on_wait = [](ScriptedLink& line) {
      if (line.waits == 15) line.come({.budget = 10});
    };
  }
  observe(2);
  if (link) {
    EXPECT_EQ(link->waits, 15);
  }
}

TEST_F(LiveViewTest, APauseEndsWithTheViewerOrWithARequest) {
  if (link) {
    link->come({.paused = true, .budget = 10});
    link->on_wait = [](ScriptedLink& line) {
      if (line.waits == 5) line.go();
    };
  }
  observe(0);
  if (link) {
    EXPECT_EQ(link->waits, 5);
    link->come({.paused = true, .budget = 10});
    link->on_wait = [this](ScriptedLink& line) {
      if (line.waits == 9) requests[static_cast<std::size_t>(Request::stop_file)] = 1;
    };
  }
  observe(1);
  if (link) {
    EXPECT_EQ(link->waits, 9);
  }
  const Clock clock{1, 0.1, 1};
  view->finish({clock, particles, {}, nullptr, {}});
  if (link) {
    EXPECT_TRUE(link->ended);
  }
}

TEST_F(LiveViewTest, DensityIsWantedOnlyWhenTheViewerWants) {
  EXPECT_FALSE(view->wants_density());
  if (link) link->come({.budget = 10, .density = true});
  observe(0);
  EXPECT_TRUE(view->wants_density());
  if (link) link->go();
  observe(1);
  EXPECT_FALSE(view->wants_density());
}

}  // namespace
}  // namespace trevi
