#include "view/live_source.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <utility>
#include <zmq.hpp>

#include "live/viewer_key.hpp"
#include "live/viewer_messages.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto between_wishes = std::chrono::milliseconds(500);  // repeated; also a probe whether the run is there
constexpr int heartbeat = 2000, presumed_gone = 10000;           // ms

constexpr std::int64_t longest_message = std::int64_t{1} << 30;  // bytes
constexpr std::size_t max_parts = 3;                             // sender, text, particles

/// Reports once that somebody without the key has called; ZeroMQ has rejected the call.
class CallerMonitor : public zmq::monitor_t {
 private:
  void on_event_handshake_failed_no_detail(const zmq_event_t&, const char*) override { tell(); }
  void on_event_handshake_failed_protocol(const zmq_event_t&, const char*) override { tell(); }
  void on_event_handshake_failed_auth(const zmq_event_t&, const char*) override { tell(); }
  void tell() {
    if (!std::exchange(told_, true))
      std::fprintf(stderr, "trevi-view: refused a caller that does not have the key of this run\n");
  }
  bool told_ = false;
};

std::string ending_of(int code) {
  switch (static_cast<ExitCode>(code)) {
    case ExitCode::done:
      return "the run is done";
    case ExitCode::stopped:
      return "the run has stopped after a checkpoint";
    case ExitCode::bad_input:
      return "the run refused its input; the terminal says why";
    default:
      return fmt::format("the run ended with exit code {}; the terminal may say why", code);
  }
}

class ZmqLiveSource : public LiveSource {
 public:
  ZmqLiveSource(const std::string& endpoint, const ViewerKey& key, const LiveOptions& options)
      : socket_(context_, zmq::socket_type::router), key_(key), message_("waiting for a run to call " + endpoint) {
    socket_.set(zmq::sockopt::curve_server, true);
    socket_.set(zmq::sockopt::curve_secretkey, key.secret);
    socket_.set(zmq::sockopt::maxmsgsize, longest_message);
    monitor_.init(
        socket_, "inproc://callers",
        ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH);
    socket_.set(zmq::sockopt::linger, 200);
    socket_.set(zmq::sockopt::router_mandatory, true);  // sending to a run that is gone is an error, not silence
    socket_.set(zmq::sockopt::heartbeat_ivl, heartbeat);
    socket_.set(zmq::sockopt::heartbeat_timeout, presumed_gone);
    try {
      socket_.bind(endpoint);
    } catch (const zmq::error_t& error) {
      throw InputError(endpoint + ": cannot listen there (" + error.what() + "); choose another port");
    }
    wishes_.budget = options.budget;
    wishes_.paused = starts_paused_ = options.paused;
  }

  void start(const RunToStart& run) {
    const auto here = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    std::string address = socket_.get(zmq::sockopt::last_endpoint);
    address = address.substr(std::string("tcp://").size());
    std::vector<std::string> words;
    if (run.ranks > 1) words = {"mpirun", "-np", std::to_string(run.ranks)};
    words.insert(words.end(), {(here / "trevi").string(), run.scene});
    words.insert(words.end(), run.arguments.begin(), run.arguments.end());
    words.insert(words.end(), {"--view", address});
    setenv(viewer_key_variable, key_.secret.c_str(), 1);  // a command line could be read by others
    child_.emplace(words, ChildOptions{.own_session = true});
    message_ = "the run is starting";
  }

  bool advance(double) override {
    changed_ = false;
    while (receive()) {
    }
    while (monitor_.check_event(0)) {
    }
    look_after_child();
    if (!run_.empty() && (wishes_changed_ || Clock::now() - last_sent_ > between_wishes)) send_wishes();
    return changed_;
  }

  std::shared_ptr<const ViewedFrame> frame() const override { return frame_; }
  const ViewedScene& scene() const override { return scene_; }
  bool paused() const override { return wishes_.paused; }
  bool at_end() const override { return over_; }
  std::string message() const override { return message_; }
  double rate() const override { return over_ || wishes_.paused ? 0 : rate_; }
  std::optional<int> exit_code() override { return child_ ? child_->exit_code() : std::nullopt; }

  std::string pace() const override {
    if (over_) return "live: over";
    if (run_.empty()) return "live: no run yet";
    return fmt::format("{}  {} rank{}", wishes_.paused ? "live: paused" : "live", scene_.ranks,
                       scene_.ranks == 1 ? "" : "s");
  }

  void pause(bool paused) override {
    wishes_.paused = paused;
    wishes_changed_ = true;
  }

  void step(int frames) override {
    if (frames > 0 && wishes_.paused) ++wishes_.single_steps;
    pause(true);
  }

  bool leave() override {
    if (over_ || run_.empty()) return true;
    wishes_.stop = wishes_changed_ = true;
    message_ = "stopping after a checkpoint";
    return false;
  }

  void want_density(bool wanted) override {
    wishes_changed_ = wishes_changed_ || wanted != wishes_.density;
    wishes_.density = wanted;
  }

 private:
  /// One message, whose parts arrive together: the sender's address, the text, perhaps particles. False if there is
  /// none.
  bool receive() {
    std::vector<std::string> parts;
    zmq::message_t part;
    while (socket_.recv(part, zmq::recv_flags::dontwait)) {
      if (parts.size() < max_parts) parts.push_back(part.to_string());
      if (!part.more()) break;
    }
    if (parts.size() >= 2) take(parts[0], parts[1], parts.size() > 2 ? parts[2] : "");
    return !parts.empty();
  }

  void take(const std::string& from, const std::string& text, const std::string& particles) {
    const bool unwatched = run_.empty() || over_;
    if (const auto scene = read_scene(text); scene && (unwatched || from == run_)) return meet(from, *scene);
    if (from != run_) return;
    if (auto frame = read_frame(text, particles)) return show(std::move(*frame));
    if (read_end(text)) finish("the run has ended");
  }

  void meet(const std::string& run, const ViewedScene& scene) {
    run_ = run;
    scene_ = scene;
    over_ = false;
    wishes_.paused = starts_paused_;
    wishes_.single_steps = 0;
    wishes_.seen = -1;
    wishes_.stop = false;
    message_.clear();
    wishes_changed_ = changed_ = true;
  }

  void show(ViewedFrame frame) {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - last_frame_).count();
    if (frame_ && seconds > 0 && frame.time > frame_->time)
      rate_ = 0.8 * rate_ + 0.2 * (frame.time - frame_->time) / seconds;
    last_frame_ = now;
    wishes_.seen = frame.step;
    frame_ = std::make_shared<const ViewedFrame>(std::move(frame));
    wishes_changed_ = changed_ = true;
  }

  void finish(const std::string& message) {
    over_ = changed_ = true;
    run_.clear();
    message_ = message;
  }

  void look_after_child() {
    if (!child_ || told_end_ || !child_->exit_code()) return;
    told_end_ = true;
    finish(ending_of(*child_->exit_code()));
  }

  void send_wishes() {
    try {
      last_sent_ = Clock::now();
      if (!socket_.send(zmq::buffer(run_), zmq::send_flags::sndmore | zmq::send_flags::dontwait)) return;
      socket_.send(zmq::buffer(text_of(wishes_)), zmq::send_flags::dontwait);
      wishes_changed_ = false;
    } catch (const zmq::error_t&) {
      finish("the run is gone: it was killed, or has failed");
    }
  }

  zmq::context_t context_;
  zmq::socket_t socket_;
  ViewerKey key_;
  CallerMonitor monitor_;
  std::optional<Child> child_;
  std::string run_;  ///< the run's address on the socket; empty: none
  ViewedScene scene_;
  std::shared_ptr<const ViewedFrame> frame_;
  ViewerWishes wishes_;
  std::string message_;
  bool starts_paused_ = false, over_ = false, told_end_ = false, changed_ = false, wishes_changed_ = false;
  Clock::time_point last_sent_, last_frame_;
  double rate_ = 0;
};

}  // namespace

std::unique_ptr<LiveSource> start_run(const RunToStart& run, const LiveOptions& options) {
  auto source = std::make_unique<ZmqLiveSource>("tcp://127.0.0.1:*", new_viewer_key(), options);
  source->start(run);
  return source;
}

std::unique_ptr<LiveSource> listen_for_run(const std::string& address, const std::string& directory,
                                           const LiveOptions& options) {
  const std::string endpoint = viewer_endpoint("--listen", address);  // before a key is made
  return std::make_unique<ZmqLiveSource>(endpoint, viewer_key_of(directory), options);
}

}  // namespace trevi
