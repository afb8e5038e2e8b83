#include "scene/formula.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <cmath>
#include <numbers>

#include "boundary/geometry/pose.hpp"
#include "trevi/error.hpp"
#include "trevi/scene.hpp"

namespace trevi {

namespace {

Real turns_of(Real x) { return x / (2 * std::numbers::pi); }
Real sine(Real x) { return sine_cosine_of_turns(turns_of(x)).sine; }
Real cosine(Real x) { return sine_cosine_of_turns(turns_of(x)).cosine; }

}  // namespace

struct Formula::Parser {
  mu::Parser parser;
  std::string text;
  Vec3 place = Vec3::Zero();
};

Formula::Formula(const std::string& text, std::string_view variables) : parser_(std::make_unique<Parser>()) {
  parser_->text = text;
  mu::Parser& parser = parser_->parser;
  try {
    parser.DefineFun("sin", sine);
    parser.DefineFun("cos", cosine);
    parser.DefineConst("pi", std::numbers::pi);
    for (std::size_t k = 0; k < variables.size(); ++k)
      parser.DefineVar(std::string(1, variables[k]), &parser_->place[static_cast<Eigen::Index>(k)]);
    parser.SetExpr(text);
    for (std::size_t k = 0; k < text.size(); ++k) {  // muParser would give a coordinate another value
      const auto at = [&](std::size_t n) { return n < text.size() ? text[n] : ' '; };
      const bool compares =
          at(k + 1) == '=' || (k > 0 && std::string_view("=<>!").find(at(k - 1)) != std::string::npos);
      if (at(k) == '=' && !compares) throw InputError("it has a single =; leave it out, or write == to compare");
    }
    int results = 0;
    parser.Eval(results);
    if (results != 1) throw InputError("it has more than one value; leave out the comma");
  } catch (const mu::Parser::exception_type& error) {
    std::string what = error.GetMsg();
    if (what.ends_with('.')) what.pop_back();
    throw InputError(fmt::format("{}; give an expression of {}, with + - * / ^ and functions such as sin, exp or min",
                                 what, fmt::join(variables, ", ")));
  }
}

Formula::~Formula() = default;
Formula::Formula(Formula&&) noexcept = default;
Formula& Formula::operator=(Formula&&) noexcept = default;

Real Formula::operator()(const Vec3& place) const {
  parser_->place = place;
  const Real value = parser_->parser.Eval();
  if (!std::isfinite(value))
    throw InputError(fmt::format("\"{}\" is not a finite number at ({:.6g}, {:.6g}, {:.6g}); change it, or the block",
                                 parser_->text, place.x(), place.y(), place.z()));
  return value;
}

SpeedProfile speed_profile(const std::string& text) {
  const auto formula = std::make_shared<Formula>(text, "zt");
  return {text, [formula, text](Real z, Real t) {
            try {
              return (*formula)({z, t, 0});
            } catch (const InputError&) {
              throw InputError(
                  fmt::format("\"{}\" is not a finite number at z = {:.6g} m, t = {:.6g} s; change it", text, z, t));
            }
          }};
}

}  // namespace trevi
