#include "live/viewer_link.hpp"

#include <chrono>
#include <zmq.hpp>

#include "live/viewer_key.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

using std::chrono::milliseconds;

constexpr int max_waiting = 4;                  // messages in a queue; credit allows one frame anyway
constexpr int last_message = 1000;              // ms that the last message may take once the run is over
constexpr std::int64_t longest_wish = 1 << 16;  // bytes
constexpr int reconnect = 200;                  // ms between calls while nobody answers
constexpr int heartbeat = 2000;                 // ms
constexpr int presumed_gone = 10000;            // ms without a heartbeat: a stopped process, a cut line
constexpr int look_interval = 5;                // ms between checks of the line while greeting
constexpr auto to_answer = milliseconds(500), to_wish = milliseconds(5000);  // patience with a viewer

/// What ZeroMQ's thread sees of the line: it knows immediately when a viewer was killed.
class LineMonitor : public zmq::monitor_t {
 public:
  bool went_up() { return std::exchange(up_, false); }
  bool went_down() { return std::exchange(down_, false); }
  bool reached() const { return reached_; }

 private:
  void on_event_handshake_succeeded(const zmq_event_t&, const char*) override { up_ = true; }
  void on_event_connected(const zmq_event_t&, const char*) override { reached_ = true; }
  void on_event_disconnected(const zmq_event_t&, const char*) override {
    up_ = false;
    down_ = true;
  }
  bool up_ = false, down_ = false, reached_ = false;
};

class ZmqLink : public ViewerLink {
 public:
  explicit ZmqLink(const std::string& endpoint) : endpoint_(endpoint), socket_(context_, zmq::socket_type::dealer) {
    socket_.set(zmq::sockopt::sndhwm, max_waiting);
    socket_.set(zmq::sockopt::linger, last_message);
    socket_.set(zmq::sockopt::immediate, true);  // nothing is kept for a viewer that is not there
    socket_.set(zmq::sockopt::reconnect_ivl, reconnect);
    socket_.set(zmq::sockopt::heartbeat_ivl, heartbeat);
    socket_.set(zmq::sockopt::heartbeat_timeout, presumed_gone);
    socket_.set(zmq::sockopt::maxmsgsize, longest_wish);
    monitor_.init(socket_, "inproc://line",
                  ZMQ_EVENT_CONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_DISCONNECTED);
  }

  void wait(int patience) override {
    try {
      std::array<zmq::pollitem_t, 1> items{{{socket_.handle(), 0, ZMQ_POLLIN, 0}}};
      zmq::poll(items, milliseconds(patience));
      follow_line();
      receive();
    } catch (const zmq::error_t&) {
      lose();
    }
  }

  void greet() override {
    const auto begin = std::chrono::steady_clock::now();
    const auto passed = [&] { return std::chrono::steady_clock::now() - begin; };
    while (!has_viewer() && passed() < (answered_ ? to_wish : to_answer)) wait(look_interval);
  }

  void introduce(const ViewedScene& scene) override {
    scene_ = text_of(scene);
    key_file_ = scene.directory + "/" + viewer_key_file;
    const ViewerKey key = viewer_key_of(scene.directory);
    try {
      socket_.set(zmq::sockopt::curve_serverkey, key.open);
      socket_.set(zmq::sockopt::curve_publickey, key.open);
      socket_.set(zmq::sockopt::curve_secretkey, key.secret);
      socket_.connect(endpoint_);
    } catch (const zmq::error_t& error) {
      throw InputError("--view: cannot call " + endpoint_ + " (" + error.what() +
                       "); give HOST:PORT, 127.0.0.1:5555 say");
    }
  }

  std::string trouble() const override {
    if (ever_answered_) return {};
    if (!monitor_.reached()) return "--view: nobody has answered at " + endpoint_;
    return "--view: what listens at " + endpoint_ + " does not have the key in " + key_file_ +
           "; give trevi-view --listen the folder of the run";
  }

  void send(const ViewedFrame& frame) override {
    const std::string text = text_of(frame);
    deliver({zmq::buffer(text), zmq::buffer(frame.shown)});
  }

  void end(const std::string& reason) override {
    const std::string text = text_of_end(reason);
    deliver({zmq::buffer(text)});
  }

 private:
  void deliver(std::initializer_list<zmq::const_buffer> parts) {
    try {
      std::size_t k = 0;
      for (const zmq::const_buffer& part : parts) {
        const bool last = ++k == parts.size();
        const auto flags = zmq::send_flags::dontwait | (last ? zmq::send_flags::none : zmq::send_flags::sndmore);
        if (!socket_.send(part, flags)) return;  // the queue is full, or nobody is there
      }
    } catch (const zmq::error_t&) {
      lose();
    }
  }

  void follow_line() {
    while (monitor_.check_event(0)) {
      if (monitor_.went_down()) lose();
      if (!monitor_.went_up()) continue;
      answered_ = ever_answered_ = true;
      deliver({zmq::buffer(scene_)});
    }
  }

  void receive() {
    for (zmq::message_t message; socket_.recv(message, zmq::recv_flags::dontwait);) {
      if (const auto wishes = read_wishes(message.to_string())) accept(*wishes);
    }
  }

  void lose() {
    answered_ = false;
    forget();
  }

  std::string endpoint_, key_file_;
  zmq::context_t context_;
  zmq::socket_t socket_;
  LineMonitor monitor_;
  std::string scene_;
  bool answered_ = false, ever_answered_ = false;
};

}  // namespace

std::unique_ptr<ViewerLink> connect_viewer(const std::string& address) {
  const std::string endpoint = viewer_endpoint("--view", address);
  try {
    return std::make_unique<ZmqLink>(endpoint);
  } catch (const zmq::error_t& error) {
    throw InputError("--view: cannot use " + endpoint + " (" + error.what() + "); give HOST:PORT, 127.0.0.1:5555 say");
  }
}

}  // namespace trevi
