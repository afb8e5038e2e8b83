// What nearly all test programs include, compiled once: a third of what compiling them takes. Each of them includes
// what it uses nevertheless.
#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mpi.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "trevi/scene.hpp"
#include "trevi/session.hpp"
#include "trevi/solver.hpp"
