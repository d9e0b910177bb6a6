// The public volumes in the data folder, if they are there: sizes and types as in their catalogue,
// voxels as programs of others read them.
#include <gmock/gmock.h>

#include <cstring>
#include <memory>

#include "io/headers/meta_image/meta_image.h"
#include "io/headers/nifti/nifti.h"
#include "io/headers/nrrd/nrrd.h"
#include "io/headers/raw/raw.h"
#include "tests/io/headers/volume_files.h"

namespace sluice {
namespace {

const std::filesystem::path kData = SLUICE_DATA_DIR;

void expectLayout(const VolumeLayout& layout, Vec3i dims, VoxelType type) {
  EXPECT_TRUE(layout.dims == dims)
      << layout.dims.x << " x " << layout.dims.y << " x " << layout.dims.z;
  EXPECT_EQ(name(layout.type), name(type));
  EXPECT_EQ(layout.time_steps, 1);
}

// Expects the voxels that Python lines write to `folder` + 'expected', in this machine's byte
// order.
void expectVoxelsOfPython(VolumeSource& source, const std::string& lines) {
  const TempFolder folder;
  ASSERT_TRUE(runsPython(folder, lines)) << readFile(folder / "script.log");
  EXPECT_TRUE(readAll(source) == readFile(folder / "expected")) << "voxels differ";
}

void expectVoxelsOfUnu(VolumeSource& source, const std::filesystem::path& path) {
  const TempFolder folder;
  const std::string unu = runs("command -v unu") ? "unu" : "teem-unu";
  ASSERT_TRUE(runs(unu + " save -f nrrd -e raw -en little -i " + path.string() + " | " + unu +
                   " data - > " + (folder / "expected").string()));
  EXPECT_TRUE(readAll(source) == readFile(folder / "expected")) << "voxels differ";
}
constexpr const char* kFindUnu = "command -v unu || command -v teem-unu";

TEST(RealVolumeTest, engineRaw) {
  const auto path = kData / "engine_256x256x128_uint8.raw";
  SLUICE_NEEDS_FILE(path);
  const auto source = openRaw(path);
  expectLayout(source->layout(), {256, 256, 128}, VoxelType::kU8);
  EXPECT_TRUE(readAll(*source) == readFile(path));
}

TEST(RealVolumeTest, walnutRaw) {
  const auto path = kData / "walnut_128x96x114_uint16.raw";
  SLUICE_NEEDS_FILE(path);
  expectLayout(openRaw(path)->layout(), {128, 96, 114}, VoxelType::kU16);
}

TEST(RealVolumeTest, niftiVoxelsAreThoseOfNibabel) {
  SLUICE_NEEDS_MODULE("nibabel");
  struct Volume {
    const char* name;
    Vec3i dims;
    VoxelType type;
    Vec3d spacing;
  };
  for (const Volume& volume :
       {Volume{"bonsai.nii.gz", {256, 256, 256}, VoxelType::kU8, {1, 1, 1}},
        Volume{"engine.nii.gz", {256, 256, 128}, VoxelType::kU8, {1, 1, 1}},
        Volume{"head-mr.nii.gz", {160, 232, 160}, VoxelType::kU8, {1, 0.898437, 0.898437}},
        Volume{"motor-map.nii.gz", {79, 95, 79}, VoxelType::kI16, {2, 2, 2}}}) {
    const auto path = kData / volume.name;
    SLUICE_NEEDS_FILE(path);
    SCOPED_TRACE(volume.name);
    const auto source = openNifti(path);
    expectLayout(source->layout(), volume.dims, volume.type);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(source->layout().spacing[axis], volume.spacing[axis], 1e-5);
    expectVoxelsOfPython(*source,
                         "import nibabel as nib\nimage = nib.load('" + path.string() +
                             "')\nopen(folder + 'expected', 'wb').write("
                             "np.asarray(image.dataobj.get_unscaled()).tobytes(order='F'))\n");
  }
}

TEST(RealVolumeTest, motorMapIsScaledAndMirrored) {
  const auto path = kData / "motor-map.nii.gz";
  SLUICE_NEEDS_FILE(path);
  const VolumeLayout layout = openNifti(path)->layout();
  EXPECT_NEAR(layout.value_scale, 0.000371, 1e-6);
  EXPECT_TRUE(layout.axes[0] == (Vec3d{-1, 0, 0}));
  EXPECT_TRUE(layout.origin == (Vec3d{78, -112, -70}));
}

TEST(RealVolumeTest, nrrdVoxelsAreThoseOfUnu) {
  SLUICE_NEEDS("teem's unu", kFindUnu);
  struct Volume {
    const char* name;
    Vec3i dims;
    VoxelType type;
  };
  for (const Volume& volume :
       {Volume{"tooth/tooth.nhdr", {103, 94, 161}, VoxelType::kU16},
        Volume{"headsq-quarter/quarter.nhdr", {64, 64, 93}, VoxelType::kI16},
        Volume{"nucleon.nrrd", {41, 41, 41}, VoxelType::kU8},
        Volume{"viscous-fingers/step_001.nrrd", {64, 64, 64}, VoxelType::kF32},
        Volume{"viscous-fingers/step_040.nrrd", {64, 64, 64}, VoxelType::kF32}}) {
    const auto path = kData / volume.name;
    SLUICE_NEEDS_FILE(path);
    SCOPED_TRACE(volume.name);
    const auto source = openNrrd(path);
    expectLayout(source->layout(), volume.dims, volume.type);
    expectVoxelsOfUnu(*source, path);
  }
}

TEST(RealVolumeTest, quarterHasItsSpacing) {
  const auto path = kData / "headsq-quarter/quarter.nhdr";
  SLUICE_NEEDS_FILE(path);
  EXPECT_TRUE(openNrrd(path)->layout().spacing == (Vec3d{3.2, 3.2, 1.5}));
}

TEST(RealVolumeTest, metaImageVoxelsAreThoseOfVtk) {
  SLUICE_NEEDS_MODULE("vtk");
  const auto path = kData / "HeadMRVolume.mhd";
  SLUICE_NEEDS_FILE(path);
  const auto source = openMetaImage(path);
  expectLayout(source->layout(), {48, 62, 42}, VoxelType::kU8);
  EXPECT_TRUE(source->layout().spacing == (Vec3d{4, 4, 4}));
  expectVoxelsOfPython(
      *source,
      "import vtk\nfrom vtk.util.numpy_support import vtk_to_numpy\n"
      "reader = vtk.vtkMetaImageReader()\nreader.SetFileName('" +
          path.string() +
          "')\nreader.Update()\n"
          "voxels = reader.GetOutput().GetPointData().GetScalars()\n"
          "open(folder + 'expected', 'wb').write(vtk_to_numpy(voxels).tobytes())\n");
}

}  // namespace
}  // namespace sluice
