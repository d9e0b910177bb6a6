#include "src/volume/voxels/device_voxel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "tests/support/memory_source.h"

namespace sluice {
namespace {

template <class T>
class DeviceVoxel : public testing::Test {
 protected:
  static constexpr VoxelType kType = voxelTypeOf<T>();

  // Every value of small types; extremes, neighbours of powers of two and random bits of others.
  static std::vector<T> samples() {
    std::vector<T> values;
    if constexpr (sizeof(T) <= 2) {
      for (int64_t v = std::numeric_limits<T>::min(); v <= std::numeric_limits<T>::max(); ++v)
        values.push_back(static_cast<T>(v));
    } else {
      for (const T v : {std::numeric_limits<T>::lowest(), std::numeric_limits<T>::max(), T{0}, T{1},
                        static_cast<T>(16777215), static_cast<T>(16777217)})
        values.push_back(v);
      std::mt19937_64 random(1);
      while (values.size() < 10000) {
        if constexpr (std::is_floating_point_v<T>) {
          values.push_back(
              static_cast<T>(std::ldexp(static_cast<double>(random() >> 11) * 0x1p-52 - 1,
                                        static_cast<int>(random() % 200) - 100)));
        } else {
          values.push_back(static_cast<T>(random()));
        }
      }
    }
    return values;
  }

  static ValueMap map() {
    VolumeLayout layout;
    layout.type = kType;
    return deviceMap(layout);
  }

  // Through toDevice, as doubles.
  static std::vector<double> devices(const std::vector<T>& stored) {
    std::vector<std::byte> out(stored.size() * bytesPerVoxel(map().type));
    toDevice(kType, std::as_bytes(std::span(stored)), out);
    std::vector<double> result(stored.size());
    visitDeviceType(map().type, [&](auto tag) {
      for (size_t i = 0; i < result.size(); ++i) {
        std::memcpy(&tag, out.data() + i * sizeof tag, sizeof tag);
        result[i] = static_cast<double>(tag);
      }
    });
    return result;
  }
};
using AllTypes =
    testing::Types<uint8_t, int8_t, uint16_t, int16_t, uint32_t, int32_t, float, double>;
TYPED_TEST_SUITE(DeviceVoxel, AllTypes);

TYPED_TEST(DeviceVoxel, deviceTypeHoldsTheRange) {
  const DeviceType expected = sizeof(TypeParam) == 1   ? DeviceType::kU8
                              : sizeof(TypeParam) == 2 ? DeviceType::kU16
                                                       : DeviceType::kF32;
  EXPECT_EQ(this->map().type, expected);
}

TYPED_TEST(DeviceVoxel, valuesComeBackThroughTheMap) {
  const auto stored = this->samples();
  const auto devices = this->devices(stored);
  const ValueMap map = this->map();
  for (size_t i = 0; i < stored.size(); ++i) {
    const double value = std::clamp<double>(static_cast<double>(stored[i]), -kLargest, kLargest);
    // Integers of up to 16 bits and single precision are exact, the rest has 24 bits.
    const bool exact = sizeof(TypeParam) <= 2 || std::is_same_v<TypeParam, float>;
    const double tolerance = exact ? 0 : std::abs(value) * 0x1p-24 + 1e-45;
    EXPECT_NEAR(map.valueOf(devices[i]), value, tolerance);
    EXPECT_NEAR(map.deviceOf(map.valueOf(devices[i])), devices[i], std::abs(devices[i]) * 1e-15);
  }
}

TYPED_TEST(DeviceVoxel, orderIsKept) {
  auto stored = this->samples();
  std::sort(stored.begin(), stored.end());
  const auto devices = this->devices(stored);
  EXPECT_TRUE(std::is_sorted(devices.begin(), devices.end()));
}

TYPED_TEST(DeviceVoxel, oneStoredValueConvertsAsManyDo) {
  const auto stored = this->samples();
  const auto devices = this->devices(stored);
  for (size_t i = 0; i < stored.size(); ++i)
    ASSERT_EQ(deviceFromStored(this->kType, static_cast<double>(stored[i])), devices[i])
        << static_cast<double>(stored[i]);
}

TYPED_TEST(DeviceVoxel, scaleAndOffsetOfTheFileAreKept) {
  VolumeLayout layout;
  layout.type = this->kType;
  layout.value_scale = -0.5;
  layout.value_offset = 1000;
  const ValueMap map = deviceMap(layout);
  const std::vector<TypeParam> stored{0, 1, 100};
  const auto devices = this->devices(stored);
  for (size_t i = 0; i < stored.size(); ++i)
    EXPECT_DOUBLE_EQ(map.valueOf(devices[i]), static_cast<double>(stored[i]) * -0.5 + 1000);
}

TYPED_TEST(DeviceVoxel, bytesPassUnchangedWhereItSaysSo) {
  EXPECT_EQ(isStoredAsDevice(this->kType),
            (std::is_same_v<TypeParam, uint8_t> || std::is_same_v<TypeParam, uint16_t>));
  if (!isStoredAsDevice(this->kType)) return;
  const auto stored = this->samples();
  const auto devices = this->devices(stored);
  for (size_t i = 0; i < stored.size(); ++i) ASSERT_EQ(devices[i], static_cast<double>(stored[i]));
}

TYPED_TEST(DeviceVoxel, noVoxelsAreNoWork) {
  EXPECT_TRUE(this->devices({}).empty());
}

template <class T>
class FloatingDeviceVoxel : public DeviceVoxel<T> {};
using FloatingTypes = testing::Types<float, double>;
TYPED_TEST_SUITE(FloatingDeviceVoxel, FloatingTypes);

TYPED_TEST(FloatingDeviceVoxel, notANumberAndInfinitiesBecomeFinite) {
  using Limits = std::numeric_limits<TypeParam>;
  const std::vector<TypeParam> stored{Limits::quiet_NaN(), Limits::infinity(),
                                      -Limits::infinity(), Limits::max(),
                                      Limits::lowest(),    Limits::denorm_min()};
  const auto devices = this->devices(stored);
  EXPECT_EQ(devices[0], kNotANumber);
  EXPECT_EQ(devices[1], kLargest);
  EXPECT_EQ(devices[2], -kLargest);
  EXPECT_EQ(devices[3], kLargest);
  EXPECT_EQ(devices[4], -kLargest);
  EXPECT_NEAR(devices[5], 0, 1e-44);
  for (size_t i = 0; i < stored.size(); ++i)
    EXPECT_EQ(deviceFromStored(this->kType, stored[i]), devices[i]);
  // Interpolating any two of them gives a finite number too.
  for (const double a : devices)
    for (const double b : devices)
      EXPECT_TRUE(std::isfinite((static_cast<float>(b) - static_cast<float>(a)) * 0.5F));
}

TEST(DeviceVoxelDeathTest, sizesMustAgree) {
  std::vector<std::byte> in(8), out(8);
  EXPECT_DEATH(toDevice(VoxelType::kF64, in, out), "check failed");
}

TEST(DeviceTypes, namesAndSizes) {
  EXPECT_STREQ(name(DeviceType::kU8), "u8");
  EXPECT_STREQ(name(DeviceType::kU16), "u16");
  EXPECT_STREQ(name(DeviceType::kF32), "f32");
  EXPECT_EQ(bytesPerVoxel(DeviceType::kU8), 1U);
  EXPECT_EQ(bytesPerVoxel(DeviceType::kU16), 2U);
  EXPECT_EQ(bytesPerVoxel(DeviceType::kF32), 4U);
}

}  // namespace
}  // namespace sluice
