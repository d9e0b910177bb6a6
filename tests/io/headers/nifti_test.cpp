// Files of NIfTI, our own and those that other programs write.
#include "io/headers/nifti/nifti.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstring>
#include <sstream>

#include "tests/io/headers/nifti_headers.h"
#include "tests/io/headers/volume_files.h"

namespace sluice::nifti_test {
namespace {

using testing::HasSubstr;

TEST(NiftiTest, readsASingleFileOfEitherByteOrder) {
  const TempFolder folder;
  const std::string voxels = knownVoxels(VoxelType::kI16, kDims);
  expectKnownVolume(*openNifti(folder.write("a.nii", plainHeader().bytes() + voxels)),
                    VoxelType::kI16, kDims);
}

TEST(NiftiTest, aFileTooSmallShowsTheArithmetic) {
  const TempFolder folder;
  EXPECT_THAT(errorOf([&] { openNifti(folder.write("a.nii", plainHeader().bytes() + "1234567")); }),
              HasSubstr("5 x 4 x 3 x 2 bytes (i16) + 352 skipped = 472 bytes expected, 359 found"));
}

TEST(NiftiTest, aTinyCompressedFileThatClaimsMuchIsTurnedAwayAtOnce) {
  SLUICE_NEEDS("gzip", "gzip --version");
  const TempFolder folder;
  HeaderBytes h = plainHeader();
  for (size_t i = 1; i < 4; ++i) h.set<int16_t>(40 + 2 * i, 32767);
  ASSERT_TRUE(runs("gzip " + folder.write("a.nii", h.bytes() + "voxels").string()));
  EXPECT_THAT(errorOf([&] { openNifti(folder / "a.nii.gz"); }),
              HasSubstr("bytes of encoded data can hold"));
}

TEST(NiftiTest, aPairWithoutItsImageIsAnError) {
  const TempFolder folder;
  const auto header = folder.write("a.hdr", plainHeader().text(344, "ni1").bytes());
  EXPECT_THAT(errorOf([&] { openNifti(header); }), HasSubstr("a.img with its voxels is missing"));
  EXPECT_THAT(errorOf([&] { openNifti(folder / "b.img"); }), HasSubstr("b.hdr: cannot be opened"));
  const auto odd = folder.write("odd", plainHeader().text(344, "ni1").bytes());
  EXPECT_THAT(errorOf([&] { openNifti(odd); }), HasSubstr("ends in .hdr"));
}

constexpr std::array<const char*, 8> kKinds = {"u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"};

// An oblique, anisotropic and sheared-free affine; a mirrored one.
constexpr const char* kAffines = R"(
import nibabel as nib
c, s = np.cos(0.3), np.sin(0.3)
turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]) @ np.array([[1.0, 0, 0], [0, s, -c], [0, c, s]])
affines = {'plain': np.eye(4), 'oblique': np.eye(4), 'mirrored': np.eye(4)}
affines['oblique'][:3, :3] = turn @ np.diag([1.0, 2, 0.5])
affines['mirrored'][:3, :3] = turn @ np.diag([-1.5, 2, 3])
for m in affines.values(): m[:3, 3] = [-7, 8, 90]
)";

TEST(NiftiPeerTest, readsTheUnitThatNibabelWrites) {
  SLUICE_NEEDS_MODULE("nibabel");
  const TempFolder folder;
  ASSERT_TRUE(runsPython(folder, R"(
import nibabel as nib
for kind in [nib.Nifti1Image, nib.Nifti2Image]:
    for unit in ['unknown', 'meter', 'mm', 'micron']:
        image = kind(known('u1', 5, 4, 3), np.eye(4))
        image.header.set_xyzt_units(unit, 'msec')
        nib.save(image, folder + unit + ('1' if kind is nib.Nifti1Image else '2') + '.nii')
)")) << readFile(folder / "script.log");
  for (const auto& [file, unit] : {std::pair{"unknown", ""},
                                   {"meter", "meter"},
                                   {"mm", "millimeter"},
                                   {"micron", "micrometer"}})
    for (const char* version : {"1", "2"})
      EXPECT_EQ(openNifti(folder / (std::string(file) + version + ".nii"))->layout().unit, unit);
}

TEST(NiftiPeerTest, readsEveryTypeVersionByteOrderAndPackingThatNibabelWrites) {
  SLUICE_NEEDS_MODULE("nibabel");
  const TempFolder folder;
  ASSERT_TRUE(runsPython(folder, std::string(kAffines) + R"(
for kind in ['u1', 'i1', 'u2', 'i2', 'u4', 'i4', 'f4', 'f8']:
    for order in '<>':
        data = known(kind, 5, 4, 3, 2)
        for version, single, pair in [(1, nib.Nifti1Image, nib.Nifti1Pair), (2, nib.Nifti2Image, nib.Nifti2Pair)]:
            stem = folder + kind + ('b' if order == '>' else 'l') + str(version)
            for cls, ends in [(single, ['.nii', '.nii.gz']), (pair, ['.img', 'z.img.gz'])]:
                header = cls.header_class(endianness=order)
                header.set_data_dtype(np.dtype(kind).newbyteorder(order))
                image = cls(data, affines['oblique'], header)
                for end in ends:
                    nib.save(image, stem + end)
)")) << readFile(folder / "script.log");
  for (size_t i = 0; i < kKinds.size(); ++i)
    for (const char* variant : {"l1", "l2", "b1", "b2"})
      for (const char* end : {".nii", ".nii.gz", ".hdr", ".img", "z.hdr.gz", "z.img.gz"}) {
        const std::string file = std::string(kKinds[i]) + variant + end;
        SCOPED_TRACE(file);
        const auto source = openNifti(folder / file);
        expectKnownVolume(*source, static_cast<VoxelType>(i), kDims, 2);
        expectNear(source->layout().spacing, {1, 2, 0.5});
      }
}

// Fills `folder` with the affine that the peer computes for each file, a line a row.
void expectAffine(const TempFolder& folder, const std::string& stem) {
  std::istringstream numbers(readFile(folder / (stem + ".txt")));
  std::array<double, 16> m{};
  for (double& number : m) ASSERT_TRUE(numbers >> number) << stem;
  const VolumeLayout layout = openNifti(folder / (stem + ".nii"))->layout();
  for (const Vec3d index : {Vec3d{0, 0, 0}, Vec3d{4, 0, 0}, Vec3d{0, 3, 0}, Vec3d{1, 2, 3}}) {
    Vec3d expected;
    for (int row = 0; row < 3; ++row) {
      const size_t at = static_cast<size_t>(row) * 4;
      expected[row] = m[at] * index.x + m[at + 1] * index.y + m[at + 2] * index.z + m[at + 3];
    }
    SCOPED_TRACE(stem);
    expectNear(worldOf(layout, index), expected, 2e-5);
  }
}

TEST(NiftiPeerTest, placesVoxelsInTheWorldAsNibabelDoes) {
  SLUICE_NEEDS_MODULE("nibabel");
  const TempFolder folder;
  ASSERT_TRUE(runsPython(folder, std::string(kAffines) + R"(
for name, affine in affines.items():
    for form in ['s', 'q', 'both']:
        image = nib.Nifti1Image(known('u1', 5, 4, 3), affine)
        image.set_sform(affine, 4 if form != 'q' else 0)
        image.set_qform(affine if form == 'q' else np.eye(4), 1 if form != 's' else 0)
        stem = folder + name + form
        nib.save(image, stem + '.nii')
        np.savetxt(stem + '.txt', nib.load(stem + '.nii').affine)
)")) << readFile(folder / "script.log");
  for (const char* name : {"plain", "oblique", "mirrored"})
    for (const char* form : {"s", "q", "both"}) expectAffine(folder, std::string(name) + form);
}

TEST(NiftiPeerTest, scalesAsNibabelDoes) {
  SLUICE_NEEDS_MODULE("nibabel");
  const TempFolder folder;
  ASSERT_TRUE(runsPython(folder, R"(
import nibabel as nib
image = nib.Nifti1Image(known('i2', 5, 4, 3), np.eye(4))
image.header.set_slope_inter(0.25, -3)
nib.save(image, folder + 'a.nii')
print('value', nib.load(folder + 'a.nii').get_fdata()[4, 3, 2])
)"));
  const auto source = openNifti(folder / "a.nii");
  const std::vector<std::byte> corner = readBox(*source, 0, {{4, 3, 2}, {5, 4, 3}});
  int16_t stored = 0;
  std::memcpy(&stored, corner.data(), sizeof(stored));
  const VolumeLayout& layout = source->layout();
  std::istringstream log(readFile(folder / "script.log"));
  std::string word;
  double expected = 0;
  ASSERT_TRUE(log >> word >> expected);
  EXPECT_NEAR(stored * layout.value_scale + layout.value_offset, expected, 1e-9);
}

TEST(NiftiPeerTest, readsWhatNiftiToolMakes) {
  SLUICE_NEEDS("nifti_tool", "nifti_tool -ver");
  const TempFolder folder;
  const std::string out = (folder / "made.nii").string();
  ASSERT_TRUE(runs("nifti_tool -make_im -prefix " + out +
                   " -new_dim 3 5 4 3 1 1 1 1 "
                   "-new_datatype 16"));
  ASSERT_TRUE(runs("nifti_tool -mod_hdr -overwrite -infiles " + out +
                   " -mod_field pixdim '-1 2 3 4 1 1 1 1' -mod_field qform_code 1"
                   " -mod_field qoffset_x 11 -mod_field scl_slope 2"));
  const auto source = openNifti(out);
  EXPECT_TRUE(source->layout().dims == kDims);
  EXPECT_EQ(source->layout().type, VoxelType::kF32);
  EXPECT_EQ(readAll(*source), std::string(240, '\0'));
  expectNear(source->layout().spacing, {2, 3, 4});
  expectNear(source->layout().axes[2], {0, 0, -1});
  expectNear(source->layout().origin, {11, 0, 0});
  EXPECT_EQ(source->layout().value_scale, 2);
}

TEST(NiftiPeerTest, readsWhatVtkWrites) {
  SLUICE_NEEDS_MODULE("vtk");
  const TempFolder folder;
  ASSERT_TRUE(runsPython(folder, R"(
import vtk
from vtk.util.numpy_support import numpy_to_vtk
image = vtk.vtkImageData()
image.SetDimensions(5, 4, 3)
image.SetSpacing(1, 2, 0.5)
image.GetPointData().SetScalars(numpy_to_vtk(known('u2', 5, 4, 3).ravel(order='F'), deep=True))
for name in ['a.nii', 'b.nii.gz', 'c.hdr']:
    writer = vtk.vtkNIFTIImageWriter()
    writer.SetInputData(image)
    writer.SetFileName(folder + name)
    writer.Write()
)")) << readFile(folder / "script.log");
  for (const char* name : {"a.nii", "b.nii.gz", "c.hdr"}) {
    SCOPED_TRACE(name);
    const auto source = openNifti(folder / name);
    expectKnownVolume(*source, VoxelType::kU16, kDims);
    expectNear(source->layout().spacing, {1, 2, 0.5});
  }
}

}  // namespace
}  // namespace sluice::nifti_test
