#include "live/viewer_messages.hpp"

#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>

#include "trevi/error.hpp"

namespace trevi {

namespace {

using Json = nlohmann::ordered_json;

std::string text_of_kind(const char* kind, Json content) {
  content["kind"] = kind;
  content["protocol"] = viewer_protocol;
  // A path need not be valid UTF-8; it is for display only.
  return content.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Calls read(json) for a message of this kind; nothing when there is anything wrong with it.
template <class T, class Read>
std::optional<T> of_kind(const char* kind, const std::string& text, Read read) {
  try {
    const Json json = Json::parse(text);
    if (json.at("kind") != kind || json.at("protocol") != viewer_protocol) return std::nullopt;
    return read(json);
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

Json array_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Vec3 vector_of(const Json& json) {
  return Vec3(json.at(0).get<Real>(), json.at(1).get<Real>(), json.at(2).get<Real>());
}

/// JSON has no nan: null stands for it.
Real number_of(const Json& json) { return json.is_null() ? NAN : json.get<Real>(); }

}  // namespace

std::string viewer_endpoint(const std::string& option, const std::string& address) {
  const std::size_t colon = address.rfind(':');
  const bool has_host = colon != std::string::npos;
  const std::string host = has_host ? address.substr(0, colon) : "127.0.0.1";
  const std::string port = has_host ? address.substr(colon + 1) : address;
  const bool digits = !port.empty() && port.size() <= 5 && port.find_first_not_of("0123456789") == std::string::npos;
  if (host.empty() || !digits || std::stoi(port) < 1 || std::stoi(port) > 65535) {
    throw InputError(option + " " + address + ": not an address; give HOST:PORT, 127.0.0.1:5555 for example");
  }
  return fmt::format("tcp://{}:{}", host, port);
}

std::string text_of(const ViewedScene& scene) {
  return text_of_kind("scene", {{"name", scene.name},
                                {"directory", scene.directory},
                                {"min", array_of(scene.min)},
                                {"max", array_of(scene.max)},
                                {"spacing", scene.spacing},
                                {"rest_density", scene.rest_density},
                                {"ranks", scene.ranks},
                                {"last_step", scene.last_step}});
}

std::string text_of(const ViewedFrame& frame) {
  Json fountains = Json::array();
  for (const FountainState& state : frame.fountains)
    fountains.push_back({{"note", state.note}, {"speed", state.speed}});
  return text_of_kind("frame", {{"step", frame.step},
                                {"time", frame.time},
                                {"particles", frame.particles},
                                {"level", frame.level},
                                {"fountains", fountains},
                                {"rank_counts", frame.rank_counts}});
}

std::string text_of(const ViewerWishes& wishes) {
  return text_of_kind("wishes", {{"paused", wishes.paused},
                                 {"single_steps", wishes.single_steps},
                                 {"seen", wishes.seen},
                                 {"budget", wishes.budget},
                                 {"density", wishes.density},
                                 {"stop", wishes.stop}});
}

std::string text_of_end(const std::string& reason) { return text_of_kind("end", {{"reason", reason}}); }

std::optional<ViewedScene> read_scene(const std::string& text) {
  return of_kind<ViewedScene>("scene", text, [](const Json& json) {
    ViewedScene scene;
    json.at("name").get_to(scene.name);
    json.at("directory").get_to(scene.directory);
    scene.min = vector_of(json.at("min"));
    scene.max = vector_of(json.at("max"));
    json.at("spacing").get_to(scene.spacing);
    json.at("rest_density").get_to(scene.rest_density);
    json.at("ranks").get_to(scene.ranks);
    json.at("last_step").get_to(scene.last_step);
    return scene;
  });
}

std::optional<ViewedFrame> read_frame(const std::string& text, const std::string& particles) {
  auto frame = of_kind<ViewedFrame>("frame", text, [](const Json& json) {
    ViewedFrame found;
    json.at("step").get_to(found.step);
    json.at("time").get_to(found.time);
    json.at("particles").get_to(found.particles);
    json.at("level").get_to(found.level);
    json.at("rank_counts").get_to(found.rank_counts);
    for (const Json& state : json.at("fountains"))
      found.fountains.push_back({number_of(state.at("note")), number_of(state.at("speed"))});
    return found;
  });
  if (!frame) return frame;
  frame->shown.resize(particles.size() / sizeof(ViewedParticle));
  const auto counted = std::accumulate(frame->rank_counts.begin(), frame->rank_counts.end(), std::int64_t{0});
  if (counted != static_cast<std::int64_t>(frame->shown.size())) return std::nullopt;
  std::memcpy(frame->shown.data(), particles.data(), frame->shown.size() * sizeof(ViewedParticle));
  return frame;
}

std::optional<ViewerWishes> read_wishes(const std::string& text) {
  return of_kind<ViewerWishes>("wishes", text, [](const Json& json) {
    return ViewerWishes{json.at("paused"), json.at("single_steps"), json.at("seen"),
                        json.at("budget"), json.at("density"),      json.at("stop")};
  });
}

std::optional<std::string> read_end(const std::string& text) {
  return of_kind<std::string>("end", text, [](const Json& json) { return json.at("reason").get<std::string>(); });
}

}  // namespace trevi
