#include "io/frames/ply_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr double largest = 1e30;
constexpr std::int64_t max_corners = 255;  // VTK counts them in one byte
constexpr std::size_t max_line = 4000;     // VTK has a buffer of 4096 bytes for a line

struct Type {
  std::size_t bytes = 0;  // 0: unknown
  bool real = false, has_sign = false;
};

Type type_of(const std::string& word) {
  const auto is = [&](const char* one, const char* other) { return word == one || word == other; };
  if (is("char", "int8")) return {1, false, true};
  if (is("uchar", "uint8")) return {1, false, false};
  if (is("short", "int16")) return {2, false, true};
  if (is("ushort", "uint16")) return {2, false, false};
  if (is("int", "int32")) return {4, false, true};
  if (is("uint", "uint32")) return {4, false, false};
  if (is("float", "float32")) return {4, true, true};
  if (is("double", "float64")) return {8, true, true};
  return {};
}

struct Property {
  std::string name;
  Type count, type;  // count: of a list
  bool is_list() const { return count.bytes > 0; }
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
  const Property* find(const char* wanted) const {
    const auto one =
        std::find_if(properties.begin(), properties.end(), [&](const Property& p) { return p.name == wanted; });
    return one == properties.end() ? nullptr : &*one;
  }
};

class Check {
 public:
  explicit Check(const std::string& path)
      : path_(path), file_(path, std::ios::binary), size_(std::filesystem::file_size(path)) {}

  void run() {
    read_head();
    const Element &vertices = elements_[0], &faces = elements_[1];
    for (const Element* element : {&vertices, &faces}) {
      for (std::int64_t n = 0; n < element->count; ++n) {
        if (text_) {
          read_line_of(*element, n);
        } else {
          read_bytes_of(*element, n);
        }
      }
    }
    if (elements_.size() > 2) return;
    while (std::getline(file_, line_)) {
      if (line_.find_first_not_of(" \t\r") != std::string::npos)
        refuse(fmt::format("there is more in it than the {} vertices and {} faces of its head", vertices.count,
                           faces.count));
    }
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const {
    throw InputError(fmt::format("{}: cannot be read as a mesh: {}; copy or save it again", path_, why));
  }

  void read_head() {
    const auto next = [&] {
      ++number_;
      if (!std::getline(file_, line_))
        refuse(number_ == 1 ? "it does not begin as a PLY file does" : "its head has no end");
      if (!line_.empty() && line_.back() == '\r') line_.pop_back();
      if (line_.size() > max_line) refuse(fmt::format("line {} is longer than {} bytes", number_, max_line));
    };
    next();
    if (line_ != "ply") refuse("it does not begin as a PLY file does");
    std::string kind;
    for (next(); line_ != "end_header"; next()) {
      std::istringstream words(line_);
      std::string word, name;
      words >> word;
      if (word == "format") {
        words >> kind;
      } else if (word == "element") {
        Element element;
        if (!(words >> element.name >> element.count) || element.count < 0 ||
            static_cast<std::uintmax_t>(element.count) > size_)
          refuse(fmt::format("its \"{}\" is more than its {} bytes can hold, or no count", line_, size_));
        elements_.push_back(element);
      } else if (word == "property") {
        Property property;
        words >> name;
        if (name == "list") {
          std::string count;
          words >> count >> name;
          property.count = type_of(count);
          if (property.count.bytes == 0 || property.count.real) name.clear();
        }
        property.type = type_of(name);
        if (elements_.empty() || property.type.bytes == 0 || !(words >> property.name))
          refuse(fmt::format("line {}, \"{}\", is no property", number_, line_));
        elements_.back().properties.push_back(property);
      } else if (word != "comment" && word != "obj_info" && !word.empty()) {
        refuse(fmt::format("line {}, \"{}\", does not belong in a head", number_, line_.substr(0, 80)));
      }
    }
    text_ = kind == "ascii";
    swapped_ = kind == (std::endian::native == std::endian::little ? "binary_big_endian" : "binary_little_endian");
    if (!text_ && !kind.starts_with("binary_")) refuse(fmt::format("its format \"{}\" is unknown", kind));
    if (elements_.size() < 2 || elements_[0].name != "vertex" || elements_[1].name != "face")
      refuse("it is not one of vertices and then of faces");
    for (const char* name : {"x", "y", "z"})
      if (elements_[0].find(name) == nullptr) refuse(fmt::format("its vertices have no {}", name));
    for (const Property& property : elements_[0].properties)
      if (property.is_list()) refuse(fmt::format("its vertices have a list, \"{}\"", property.name));
    corners_ = elements_[1].find("vertex_indices");
    if (corners_ == nullptr) corners_ = elements_[1].find("vertex_index");
    if (corners_ == nullptr || !corners_->is_list() || corners_->type.real)
      refuse("its faces have no list of whole numbers \"vertex_indices\"");
  }

  void check(const Element& element, std::int64_t n, const Property& property, double value) const {
    const bool is_corner = &property == corners_;
    if (!property.type.real && value != std::floor(value))
      refuse(
          fmt::format("{} {}{} has {} = {}, which is no whole number", element.name, n, place(), property.name, value));
    if (std::abs(value) < largest && (!is_corner || (value >= 0 && value < static_cast<double>(elements_[0].count))))
      return;
    refuse(fmt::format("{} {}{} has {} = {}, which is {}", element.name, n, place(), property.name, value,
                       is_corner ? "no vertex of it" : "no finite number"));
  }
  std::int64_t checked_count(const Element& element, std::int64_t n, const Property& property, double count) const {
    const int least = &property == corners_ ? 3 : 0;
    if (count >= least && count <= static_cast<double>(max_corners) && count == std::floor(count))
      return static_cast<std::int64_t>(count);
    refuse(fmt::format("{} {}{} has a list of {}, which is no number from {} to {}", element.name, n, place(), count,
                       least, max_corners));
  }
  std::string place() const { return text_ ? fmt::format(" (line {})", number_) : ""; }

  // VTK reads one element from each line.
  void read_line_of(const Element& element, std::int64_t n) {
    ++number_;
    if (!std::getline(file_, line_))
      refuse(fmt::format("it ends after {} of the {} of \"element {}\"", n, element.count, element.name));
    if (line_.size() > max_line) refuse(fmt::format("line {} is longer than {} bytes", number_, max_line));
    std::istringstream words(line_);
    std::string word;
    const auto next = [&] {
      if (!(words >> word)) refuse(fmt::format("line {} ends before all of {} {} is told", number_, element.name, n));
      double value = 0;
      if (!is_number(word, value))
        refuse(fmt::format("line {}: \"{}\" is no number", number_, word.substr(0, 80).c_str()));
      return value;
    };
    for (const Property& property : element.properties) {
      const std::int64_t count = property.is_list() ? checked_count(element, n, property, next()) : 1;
      for (std::int64_t k = 0; k < count; ++k) check(element, n, property, next());
    }
    if (words >> word) refuse(fmt::format("line {} has more than {} {}", number_, element.name, n));
  }

  void read_bytes_of(const Element& element, std::int64_t n) {
    const auto next = [&](const Type& type) {
      std::array<char, 8> bytes{};
      if (!file_.read(bytes.data(), static_cast<std::streamsize>(type.bytes)))
        refuse(fmt::format("it ends after {} of the {} of \"element {}\"", n, element.count, element.name));
      if (!swapped_) return value_of(type, bytes);
      std::array<char, 8> turned{};
      for (std::size_t k = 0; k < type.bytes; ++k) turned[k] = bytes[type.bytes - 1 - k];
      return value_of(type, turned);
    };
    for (const Property& property : element.properties) {
      const std::int64_t count = property.is_list() ? checked_count(element, n, property, next(property.count)) : 1;
      for (std::int64_t k = 0; k < count; ++k) check(element, n, property, next(property.type));
    }
  }

  template <class T>
  static double as(const std::array<char, 8>& bytes) {
    T value{};
    std::memcpy(&value, bytes.data(), sizeof(T));
    return static_cast<double>(value);
  }
  static double value_of(const Type& type, const std::array<char, 8>& bytes) {
    if (type.real) return type.bytes == 4 ? as<float>(bytes) : as<double>(bytes);
    if (type.bytes == 1) return type.has_sign ? as<std::int8_t>(bytes) : as<std::uint8_t>(bytes);
    if (type.bytes == 2) return type.has_sign ? as<std::int16_t>(bytes) : as<std::uint16_t>(bytes);
    return type.has_sign ? as<std::int32_t>(bytes) : as<std::uint32_t>(bytes);
  }

  const std::string& path_;
  std::ifstream file_;
  std::uintmax_t size_;  // bytes
  std::string line_;
  std::int64_t number_ = 0;  // of the line
  bool text_ = false, swapped_ = false;
  std::vector<Element> elements_;
  const Property* corners_ = nullptr;
};

}  // namespace

bool is_number(const std::string& word, double& value) {
  char* end = nullptr;
  value = std::strtod(word.c_str(), &end);
  return !word.empty() && end == word.c_str() + word.size();
}

void check_ply(const std::string& path) { Check(path).run(); }

}  // namespace trevi
