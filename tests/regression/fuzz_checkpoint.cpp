// libFuzzer target: HDF5 files as checkpoint and as particle input. Whatever the file is, the answer is particles or an
// InputError. Since most blind changes end at HDF5's own checksums, half of the mutations go through HDF5: attributes
// and tables are removed, overwritten, or replaced by others of another shape and type. Built with TREVI_FUZZ.
#include <hdf5.h>

#include <array>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "io/hdf5/checkpoint.hpp"
#include "io/hdf5/hdf5_rows.hpp"
#include "io/run_directory/files.hpp"
#include "trevi/error.hpp"

namespace {

constexpr std::array attributes = {"format",   "step",         "time", "dt",
                                   "substeps", "wall_seconds", "seed", "scene_overrides"};
constexpr std::array tables = {"/particles/id",  "/particles/position", "/particles/velocity",
                               "/particles/hue", "/checksums/id",       "/checksums/position"};

std::string as_file(const trevi::MemoryFile& file, const unsigned char* data, std::size_t size) {
  std::ofstream(file.path(), std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return file.path();
}

template <class Read>
void try_reading(const Read& read) {
  try {
    read();
  } catch (const trevi::InputError&) {
  }
}

using Random = std::minstd_rand;

void change_attribute(hid_t file, Random& random) {
  const char* name = attributes[random() % attributes.size()];
  H5Adelete(file, name);
  if (random() % 4 == 0) return;
  const std::array<double, 6> values = {0, -1, 1e300, -0.5, 9e18, 3};
  const double value = values[random() % values.size()];
  const hsize_t count = random() % 3;
  const hid_t space = random() % 4 == 0 ? H5Screate_simple(1, &count, nullptr) : H5Screate(H5S_SCALAR);
  const hid_t type = random() % 2 == 0 ? H5T_IEEE_F64LE : H5T_STD_I64LE;
  const hid_t attribute = H5Acreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  const std::array<double, 3> row = {value, value, value};
  H5Awrite(attribute, H5T_NATIVE_DOUBLE, row.data());
  H5Aclose(attribute);
  H5Sclose(space);
}

void change_table(hid_t file, Random& random) {
  const char* name = tables[random() % tables.size()];
  H5Ldelete(file, name, H5P_DEFAULT);
  if (random() % 4 == 0) return;
  const std::array<hsize_t, 3> shape = {random() % 12, random() % 5, 1 + random() % 2};
  const std::array<hid_t, 5> types = {H5T_IEEE_F64LE, H5T_IEEE_F32BE, H5T_STD_I64LE, H5T_STD_U8LE, H5T_C_S1};
  const hid_t space = H5Screate_simple(static_cast<int>(random() % 4), shape.data(), nullptr);
  const hid_t dataset =
      H5Dcreate2(file, name, types[random() % types.size()], space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const std::array<double, 120> numbers = {0.5, 1.5, -2, 1e308, 7};
  if (random() % 2 == 0) H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data());
  H5Dclose(dataset);
  H5Sclose(space);
}

}  // namespace

extern "C" std::size_t LLVMFuzzerMutate(unsigned char* data, std::size_t size, std::size_t most);

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  MPI_Init(argc, argv);
  trevi::silence_hdf5();
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(unsigned char* data, std::size_t size, std::size_t most, unsigned seed) {
  Random random(seed);
  if (random() % 2 == 0) return LLVMFuzzerMutate(data, size, most);
  const trevi::MemoryFile memory;
  const hid_t file = H5Fopen(as_file(memory, data, size).c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  if (file < 0) return LLVMFuzzerMutate(data, size, most);
  random() % 2 == 0 ? change_attribute(file, random) : change_table(file, random);
  H5Fclose(file);
  std::ifstream changed(memory.path(), std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(changed), {});
  if (bytes.size() > most) return LLVMFuzzerMutate(data, size, most);
  std::copy(bytes.begin(), bytes.end(), data);
  return bytes.size();
}

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const trevi::MemoryFile memory;
  const std::string path = as_file(memory, data, size);
  try_reading([&] { trevi::read_checkpoint(MPI_COMM_SELF, path); });
  try_reading([&] { trevi::read_particle_file(MPI_COMM_SELF, path); });
  return 0;
}
