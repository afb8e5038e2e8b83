#include "io/frames/vtk_compressor.hpp"

#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>

namespace trevi {

vtkStandardNewMacro(VtkCompressor);

namespace {

constexpr size_t batch = 128;  // blocks, of 22 KiB by VTK's default

}  // namespace

void VtkCompressor::expect(vtkUnstructuredGrid* grid) {
  std::vector<vtkDataArray*> arrays = {grid->GetPoints()->GetData(), grid->GetCells()->GetConnectivityArray(),
                                       grid->GetCells()->GetOffsetsArray(), grid->GetCellTypesArray()};
  for (int k = 0; k < grid->GetPointData()->GetNumberOfArrays(); ++k) {
    arrays.push_back(grid->GetPointData()->GetArray(k));
  }
  for (vtkDataArray* array : arrays) {
    const auto bytes = static_cast<size_t>(array->GetNumberOfValues()) * static_cast<size_t>(array->GetDataTypeSize());
    if (bytes > 0) expected_.emplace_back(static_cast<const unsigned char*>(array->GetVoidPointer(0)), bytes);
  }
}

size_t VtkCompressor::CompressBuffer(const unsigned char* data, size_t size, unsigned char* compressed, size_t space) {
  const auto ready = [&] {
    return next_ < blocks_.size() && blocks_[next_].data() == data && blocks_[next_].size() == size;
  };
  if (!ready()) compress_from({data, size});
  if (!ready() || sizes_[next_] == 0 || sizes_[next_] > space) {  // 0: it failed, and will report that when done here
    ++unexpected_;
    return vtkZLibDataCompressor::CompressBuffer(data, size, compressed, space);
  }
  std::copy_n(results_.data() + next_ * room_, sizes_[next_], compressed);
  return sizes_[next_++];
}

VtkCompressor::Bytes VtkCompressor::expected_from(Bytes first) const {
  for (const Bytes bytes : expected_) {
    const auto at = reinterpret_cast<std::uintptr_t>(first.data()) - reinterpret_cast<std::uintptr_t>(bytes.data());
    if (at < bytes.size() && first.size() <= bytes.size() - at) return bytes.subspan(at);
  }
  return {};
}

void VtkCompressor::compress_from(Bytes first) {
  blocks_.clear();
  next_ = 0;
  for (Bytes rest = expected_from(first); !rest.empty() && blocks_.size() < batch;) {
    blocks_.push_back(rest.first(std::min(first.size(), rest.size())));
    rest = rest.subspan(blocks_.back().size());
  }
  if (blocks_.empty()) return;
  room_ = GetMaximumCompressionSpace(first.size());
  results_.resize(batch * room_);
  sizes_.resize(batch);
  compressors_.for_each([&](auto& one) { one->SetCompressionLevel(GetCompressionLevel()); });
  for_each_part(static_cast<LocalId>(blocks_.size()), [&](LocalId part) {
    const auto k = static_cast<size_t>(part);
    sizes_[k] = compressors_.mine()->Compress(blocks_[k].data(), blocks_[k].size(), results_.data() + k * room_, room_);
  });
}

}  // namespace trevi
