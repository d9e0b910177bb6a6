// `sluice surface` as a user runs it, and its meshes as VTK reads them.
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::Test;

// Prints of each mesh: points, triangles, sides with one triangle, sides with more than two, and
// whether its points and normals are those of VTK's own surface of the same volume ("-": there is
// none), if points are moved by up to kLeastShare of the spacing.
constexpr const char* kCheck = R"(
import sys, vtk, numpy as np
from vtk.util.numpy_support import vtk_to_numpy
volume, value, meshes = sys.argv[1], float(sys.argv[2]), sys.argv[3:]
def sides(mesh, boundary):
    found = vtk.vtkFeatureEdges()
    found.SetInputData(mesh)
    found.FeatureEdgesOff(); found.ManifoldEdgesOff()
    found.SetBoundaryEdges(boundary); found.SetNonManifoldEdges(not boundary)
    found.Update()
    return found.GetOutput().GetNumberOfCells()
def points_of(mesh):
    return (vtk_to_numpy(mesh.GetPoints().GetData()).astype(float),
            vtk_to_numpy(mesh.GetPointData().GetNormals()).astype(float))
own = None
if volume != '-':
    reader = vtk.vtkMetaImageReader(); reader.SetFileName(volume)
    surface = vtk.vtkFlyingEdges3D(); surface.SetInputConnection(reader.GetOutputPort())
    surface.SetValue(0, value); surface.ComputeNormalsOn(); surface.Update()
    own = surface.GetOutput()
for name in meshes:
    reader = {'ply': vtk.vtkPLYReader, 'stl': vtk.vtkSTLReader, 'obj': vtk.vtkOBJReader}[name[-3:]]()
    reader.SetFileName(name); reader.Update()
    mesh = reader.GetOutput()
    line = [mesh.GetNumberOfPoints(), mesh.GetNumberOfPolys(), sides(mesh, True), sides(mesh, False)]
    if own:
        assert own.GetNumberOfPoints() == mesh.GetNumberOfPoints(), own.GetNumberOfPoints()
        (a, an), (b, bn) = points_of(own), points_of(mesh)
        locator = vtk.vtkPointLocator(); locator.SetDataSet(own); locator.BuildLocator()
        nearest = np.array([locator.FindClosestPoint(p) for p in b])
        assert len(set(nearest)) == len(b)
        line += [np.abs(a[nearest] - b).max() < 0.003, np.sum(an[nearest] * bn, axis=1).min() > 0.9999]
    print(*line)
)";

class Meshes : public Test {
 protected:
  void SetUp() override {
    const bool has_vtk = runCommand("/usr/bin/python3 -c 'import vtk, numpy'").status == 0;
    if (!has_vtk) GTEST_SKIP() << "python3 with vtk and numpy is missing";
    program_.folder.write("check.py", kCheck);
  }
  std::string check(const std::string& arguments) const {
    return runCommand("cd " + shellQuoted(program_.folder.path().string()) +
                      " && /usr/bin/python3 check.py " + arguments)
        .output;
  }

  const Program program_;
};

TEST_F(Meshes, areWatertightInEachFormat) {
  ASSERT_EQ(program_.run("synth phantom -q -o v.nrrd --dims 70,66,60").status, 0);
  std::string expected;
  for (const char* format : {"ply", "stl", "obj"}) {
    const auto report =
        program_.json(std::string("surface v.nrrd --iso 40 --closed -o a.") + format);
    expected += fmt::format("{} {} 0 0\n", report["vertices"].get<int64_t>(),
                            report["triangles"].get<int64_t>());
    EXPECT_GT(report["triangles"].get<int64_t>(), 10'000);
  }
  EXPECT_EQ(check("- 0 a.ply a.stl a.obj"), expected);
}

TEST_F(Meshes, haveTheVerticesAndNormalsOfVtk) {
  for (const char* type : {"u8", "u16", "f32"}) {
    const std::string made = std::string("synth phantom -q --force -o v.mhd --dims 90,80,70 ") +
                             "--spacing 1,0.5,1.5 --type " + type;
    ASSERT_EQ(program_.run(made).status, 0);
    const auto info = program_.json("info v.mhd");
    const double value = 0.23 * info["value_range"][1].get<double>();
    const auto report = program_.json(fmt::format("surface v.mhd --iso {} -o a.ply", value));
    const std::string found = check(fmt::format("v.mhd {} a.ply", value));
    EXPECT_TRUE(found.ends_with(" 0 True True\n")) << type << ": " << found;
    EXPECT_TRUE(found.starts_with(fmt::format("{} ", report["vertices"].get<int64_t>()))) << found;
  }
}

TEST_F(Meshes, ofCoarserLevelsLieInTheSamePlace) {
  ASSERT_EQ(program_.run("synth phantom -q -o v.nrrd --dims 128,128,128").status, 0);
  const auto fine = program_.json("surface v.nrrd --iso 40 -q -o a.ply");
  const auto coarse =
      program_.json("surface v.nrrd --iso 40 -q --level 1 --levels always -o b.ply");
  EXPECT_EQ(coarse["level_dims"][0], 64);
  EXPECT_LT(coarse["vertices"].get<double>(), 0.4 * fine["vertices"].get<double>());
  program_.folder.write("near.py", R"(
import sys, vtk
def load(name):
    reader = vtk.vtkPLYReader(); reader.SetFileName(name); reader.Update()
    return reader.GetOutput()
fine, coarse = load('a.ply'), load('b.ply')
print(max(abs(a - b) < 1.5 for a, b in zip(fine.GetBounds(), coarse.GetBounds())))
mass = [vtk.vtkMassProperties(), vtk.vtkMassProperties()]
for m, mesh in zip(mass, (fine, coarse)):
    m.SetInputData(mesh); m.Update()
print(abs(mass[0].GetVolume() - mass[1].GetVolume()) < 0.02 * mass[0].GetVolume())
)");
  EXPECT_EQ(runCommand("cd " + shellQuoted(program_.folder.path().string()) +
                       " && /usr/bin/python3 near.py")
                .output,
            "True\nTrue\n");
}

TEST(SurfaceCommand, readsOnlyBlocksThatTheSurfacePassesThrough) {
  const Program program;
  const auto report =
      program.json("surface synth:slab,dims=256x256x256,share=0.2 --iso 1 -o a.ply");
  EXPECT_GT(report["blocks"]["read"].get<int64_t>(), 0);
  EXPECT_LT(report["blocks"]["read"].get<int64_t>(), report["blocks"]["count"].get<int64_t>() / 2);
}

TEST(SurfaceCommand, isTheSameForAnyThreadsAndCrop) {
  const Program program;
  ASSERT_EQ(program.run(std::string("surface ") + kSmall + " --iso 90 -q -j1 -o a.ply").status, 0);
  ASSERT_EQ(
      program
          .run(std::string("surface ") + kSmall + " --iso 90 -q -j4 --crop 0,0,0,48,40,36 -o b.ply")
          .status,
      0);
  EXPECT_TRUE(readFile(program.folder / "a.ply") == readFile(program.folder / "b.ply"));
}

TEST(SurfaceCommand, saysInOneLineWhatIsWrong) {
  const Program program;
  const std::string surface = std::string("surface ") + kSmall + " --iso 90 ";
  program.folder.write("other.ply", "ply of somebody else");
  program.folder.write("other.stl", "sluice render v.raw\n" + std::string(200, ' '));
  struct Case {
    std::string arguments, part;
  };
  for (const Case& c :
       {Case{surface + "-o a.off", ".ply, .stl or .obj"}, Case{surface + "-o other.ply", "--force"},
        Case{surface + "-o other.stl", "--force"}, Case{surface + "-o no/a.ply", "no/a.ply"},
        Case{surface + "-o a.ply --level 5", "no level 5"},
        Case{surface + "-o a.ply --memory 10K", "--memory"},
        Case{surface + "-o a.ply --crop 100,100,100,120,120,120", "crop"},
        Case{surface + "-o a.ply --time 3", "--time 3"}}) {
    const CommandResult result = program.run(c.arguments);
    EXPECT_EQ(result.status, 1) << c.arguments;
    EXPECT_TRUE(isOneLine(result.output)) << result.output;
    EXPECT_NE(result.output.find(c.part), std::string::npos) << result.output;
  }
  EXPECT_FALSE(program.exists("a.ply"));
  EXPECT_EQ(program.run("surface synth:shells -o a.ply").status, 2);
  EXPECT_EQ(program.run(surface + "-q -o other.ply --force").status, 0);
  EXPECT_EQ(program.run(surface + "-q -o other.ply").status, 0);  // ours now
}

TEST(SurfaceCommand, warnsOfAnEmptyMesh) {
  const Program program;
  const CommandResult result =
      program.run(std::string("surface ") + kSmall + " --iso 300 -o a.ply");
  EXPECT_EQ(result.status, 0);
  EXPECT_NE(result.output.find("no surface at 300"), std::string::npos) << result.output;
}

TEST(SurfaceCommand, leavesNothingBehindWhenItIsInterrupted) {
  const Program program;
  const CommandResult result = program.signalled(
      "surface synth:noise,dims=512x512x512 --iso 100 -q -o a.ply", "INT", "test -e a.ply.0.tmp");
  EXPECT_EQ(result.status, 130) << result.output;
  for (const auto& entry : std::filesystem::directory_iterator(program.folder.path()))
    EXPECT_EQ(entry.path().filename().string().find("a.ply"), std::string::npos) << entry.path();
}

}  // namespace
}  // namespace sluice
