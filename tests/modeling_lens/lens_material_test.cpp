#include "modeling/glasses/lens_material.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace annulus {
namespace {

using testing::HasSubstr;

TEST(LensMaterial, EveryMaterialOfTheCatalogueIsValidAndFoundByItsName) {
  double index = 0.0;
  for (const LensMaterial& material : LensMaterials()) {
    EXPECT_TRUE(Validate(material)) << material.name;
    EXPECT_GT(material.index, index) << "by rising index";
    index = material.index;
    const auto found = FindLensMaterial(material.name);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->index, material.index);
  }
}

TEST(LensMaterial, NominalIndicesAreThoseOfTheTradeWithTheirLine) {
  EXPECT_EQ(FindLensMaterial("cr39")->index, 1.498);
  EXPECT_EQ(FindLensMaterial("polycarbonate")->index, 1.586);
  EXPECT_EQ(FindLensMaterial("1.67")->index, 1.67);
  EXPECT_EQ(FindLensMaterial("1.74")->index, 1.74);
  EXPECT_EQ(SpectralLineName(FindLensMaterial("cr39")->line), "d");
  EXPECT_EQ(SpectralLineName(FindLensMaterial("1.74")->line), "e");
}

TEST(LensMaterial, AnUnknownNameListsTheKnownOnes) {
  const auto found = FindLensMaterial("diamond");
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().Text(), HasSubstr("diamond"));
  EXPECT_THAT(found.error().Text(), HasSubstr("cr39, crown-glass, trivex"));
}

TEST(LensMaterial, ImpossibleNumbersAreRefusedByName) {
  EXPECT_TRUE(Validate({"own", 1.56, SpectralLine::kE, 38.0, 1.28}));
  EXPECT_THAT(Validate({"own", 1.0, SpectralLine::kE, 38.0, 1.28}).error().Text(), HasSubstr("the index is 1"));
  EXPECT_THAT(Validate({"own", 1.56, SpectralLine::kE, 0.0, 1.28}).error().Text(), HasSubstr("Abbe"));
  EXPECT_THAT(Validate({"own", 1.56, SpectralLine::kE, 38.0, 1280.0}).error().Text(), HasSubstr("density"));
  EXPECT_FALSE(Validate({"own", std::numeric_limits<double>::quiet_NaN(), SpectralLine::kE, 38.0, 1.28}));
}

}  // namespace
}  // namespace annulus
