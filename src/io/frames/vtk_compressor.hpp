// The compressor of VTK's XML writer, which compresses an array block after block on one thread. This one is told of
// the arrays in advance: when it is asked for a block of one of them, it also compresses the blocks that follow, shared
// among the threads, and hands them out when they are asked for. Each block goes through VTK's own compressor
// separately, so the file does not depend on the number of threads. Blocks of other arrays are compressed when they are
// asked for, as usual. Memory: the compressed blocks of one batch, 3 MB. Rank-local.
#pragma once

#include <vtkNew.h>
#include <vtkZLibDataCompressor.h>

#include <span>
#include <vector>

#include "base/threads.hpp"

class vtkUnstructuredGrid;

namespace trevi {

class VtkCompressor : public vtkZLibDataCompressor {
 public:
  // No vtkTypeMacro: the file names the class with which readers are to decompress it, and that must be VTK's.
  static VtkCompressor* New();

  /// The arrays of a grid, which must not change until it is written.
  void expect(vtkUnstructuredGrid* grid);

  /// Number of blocks so far that belong to no expected array.
  int unexpected_blocks() const { return unexpected_; }

 protected:
  size_t CompressBuffer(const unsigned char* data, size_t size, unsigned char* compressed, size_t space) override;

 private:
  using Bytes = std::span<const unsigned char>;

  void compress_from(Bytes first);
  Bytes expected_from(Bytes first) const;

  std::vector<Bytes> expected_;
  // The batch: blocks that are contiguous in the arrays, and the compressed data, each in its own part of results_.
  std::vector<Bytes> blocks_;
  std::vector<size_t> sizes_;
  std::vector<unsigned char> results_;
  size_t room_ = 0;  ///< for one block in results_
  size_t next_ = 0;  ///< block to be asked for
  int unexpected_ = 0;
  PerThread<vtkNew<vtkZLibDataCompressor>> compressors_;
};

}  // namespace trevi
