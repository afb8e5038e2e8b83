#include "live/viewer_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "trevi/error.hpp"

namespace trevi {

namespace {

using Json = nlohmann::ordered_json;

/// Thrown for a number that no run and no viewer sends.
struct Damaged {};

constexpr int max_ranks = 1 << 24, highest_level = 62;

std::string text_of_kind(const char* kind, Json content) {
  content["kind"] = kind;
  content["protocol"] = viewer_protocol;
  // A path need not be valid UTF-8; it is for display only.
  return content.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Calls read(json) for a message of this kind; does nothing if there is anything wrong with it.
template <class T, class Read>
std::optional<T> of_kind(const char* kind, const std::string& text, Read read) {
  try {
    const Json json = Json::parse(text);
    if (json.at("kind") != kind || json.at("protocol") != viewer_protocol) return std::nullopt;
    return read(json);
  } catch (const Json::exception&) {
  } catch (const Damaged&) {
  }
  return std::nullopt;
}

Json array_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Vec3 vector_of(const Json& json) {
  return Vec3(json.at(0).get<Real>(), json.at(1).get<Real>(), json.at(2).get<Real>());
}

/// JSON has no nan: null represents it.
Real number_of(const Json& json) { return json.is_null() ? NAN : json.get<Real>(); }

/// The JSON library converts any number to an integer, 1e300 and 2^63 included; a value that is no count means damage.
std::int64_t whole(const Json& json, std::int64_t least, std::int64_t most = std::int64_t{1} << 62) {
  const bool fits = json.is_number_integer() && (!json.is_number_unsigned() || json.get<std::uint64_t>() <= INT64_MAX);
  const std::int64_t value = fits ? json.get<std::int64_t>() : least - 1;
  if (value < least || value > most) throw Damaged();
  return value;
}

Real positive(const Json& json) {
  const Real value = json.get<Real>();
  if (!(value > 0) || !std::isfinite(value)) throw Damaged();
  return value;
}

/// Whether the counts of the ranks add up to this number of particles.
bool add_up(const std::vector<std::int64_t>& counts, std::int64_t particles) {
  for (const std::int64_t count : counts) {
    if (count > particles) return false;
    particles -= count;
  }
  return particles == 0;
}

bool is_somewhere(const ViewedParticle& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

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
    if (!(scene.max - scene.min).allFinite() || !((scene.max - scene.min).minCoeff() > 0)) throw Damaged();
    scene.spacing = positive(json.at("spacing"));
    scene.rest_density = positive(json.at("rest_density"));
    scene.ranks = static_cast<int>(whole(json.at("ranks"), 1, max_ranks));
    scene.last_step = whole(json.at("last_step"), 0);
    return scene;
  });
}

std::optional<ViewedFrame> read_frame(const std::string& text, const std::string& particles) {
  auto frame = of_kind<ViewedFrame>("frame", text, [](const Json& json) {
    ViewedFrame found;
    found.step = whole(json.at("step"), 0);
    json.at("time").get_to(found.time);
    found.particles = whole(json.at("particles"), 0);
    found.level = static_cast<int>(whole(json.at("level"), 0, highest_level));
    for (const Json& count : json.at("rank_counts")) found.rank_counts.push_back(whole(count, 0));
    if (!std::isfinite(found.time)) throw Damaged();
    for (const Json& state : json.at("fountains"))
      found.fountains.push_back({number_of(state.at("note")), number_of(state.at("speed"))});
    return found;
  });
  if (!frame) return frame;
  const std::size_t count = particles.size() / sizeof(ViewedParticle);
  const bool whole_rows = particles.size() == count * sizeof(ViewedParticle);
  if (!whole_rows || !add_up(frame->rank_counts, static_cast<std::int64_t>(count))) return std::nullopt;
  frame->shown.resize(count);
  if (count > 0) std::memcpy(frame->shown.data(), particles.data(), particles.size());
  if (!std::all_of(frame->shown.begin(), frame->shown.end(), is_somewhere)) return std::nullopt;
  return frame;
}

std::optional<ViewerWishes> read_wishes(const std::string& text) {
  return of_kind<ViewerWishes>("wishes", text, [](const Json& json) {
    return ViewerWishes{json.at("paused"),          whole(json.at("single_steps"), 0),
                        whole(json.at("seen"), -1), whole(json.at("budget"), 0),
                        json.at("density"),         json.at("stop")};
  });
}

std::optional<std::string> read_end(const std::string& text) {
  return of_kind<std::string>("end", text, [](const Json& json) { return json.at("reason").get<std::string>(); });
}

}  // namespace trevi
