// Clang before 16 has no __builtin_source_location, so libstdc++ gives it no std::source_location: lend it one.
// Included before everything else by the fuzz targets (TREVI_FUZZ), which need clang, and by jobs/lint.sh.
#pragma once

#if defined(__clang__) && __clang_major__ < 16
namespace std {
struct source_location {
  static constexpr source_location current() noexcept { return {}; }
  constexpr const char* file_name() const noexcept { return __builtin_FILE(); }
  constexpr const char* function_name() const noexcept { return __builtin_FUNCTION(); }
  constexpr unsigned line() const noexcept { return __builtin_LINE(); }
  constexpr unsigned column() const noexcept { return 0; }
};
}  // namespace std
#endif
