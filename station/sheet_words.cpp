#include "station/sheet_words.h"

#include <array>

namespace annulus {
namespace {

struct Term {
  std::string_view id;
  std::string_view japanese;
};

constexpr std::array kTerms{
    Term{"head_girth", "頭囲"},
    Term{"neck_girth", "頸囲"},
    Term{"neck_base_girth", "頸付根囲"},
    Term{"chest_girth", "胸囲(チェスト)"},
    Term{"bust_girth", "乳頭位胸囲(バスト)"},
    Term{"under_bust_girth", "下部胸囲(アンダーバスト)"},
    Term{"waist_girth", "胴囲(ウエスト)"},
    Term{"omphalion_girth", "臍位腹囲"},
    Term{"top_hip_girth", "腹囲(ミドルヒップ)"},
    Term{"hip_girth", "腰囲(ヒップ)"},
    Term{"head_perimeter", "頭囲(体表に沿う周長)"},
    Term{"neck_perimeter", "頸囲(体表に沿う周長)"},
    Term{"chest_perimeter", "胸囲(体表に沿う周長)"},
    Term{"bust_perimeter", "乳頭位胸囲(体表に沿う周長)"},
    Term{"under_bust_perimeter", "下部胸囲(体表に沿う周長)"},
    Term{"waist_perimeter", "胴囲(体表に沿う周長)"},
    Term{"top_hip_perimeter", "腹囲(体表に沿う周長)"},
    Term{"hip_perimeter", "腰囲(体表に沿う周長)"},
    Term{"vertex_height", "身長(頭頂高)"},
    Term{"stature", "身長"},
    Term{"head_height", "全頭高"},
    Term{"head_level_height", "頭囲位高"},
    Term{"neck_height", "頸囲位高"},
    Term{"neck_back_height", "頸椎高"},
    Term{"neck_base_back_height", "頸椎高"},
    Term{"neck_front_height", "頸窩高"},
    Term{"neck_base_front_height", "頸窩高"},
    Term{"shoulder_height", "肩峰高"},
    Term{"axilla_height", "腋窩高"},
    Term{"chest_height", "胸囲位高"},
    Term{"bust_height", "乳頭高(バスト高)"},
    Term{"bust_point_height", "乳頭高(バスト高)"},
    Term{"under_bust_height", "アンダーバスト高"},
    Term{"waist_height", "胴高(ウエスト高)"},
    Term{"omphalion_height", "臍高"},
    Term{"top_hip_height", "ミドルヒップ高"},
    Term{"iliac_height", "腸骨稜高"},
    Term{"hip_height", "腰高(ヒップ高)"},
    Term{"crotch_height", "股下高"},
    Term{"chest_breadth", "胸部横径"},
    Term{"chest_depth", "胸部矢状径"},
    Term{"bust_breadth", "乳頭位胸部横径"},
    Term{"bust_depth", "乳頭位胸部矢状径"},
    Term{"waist_breadth", "胴部横径"},
    Term{"waist_depth", "胴部矢状径"},
    Term{"hip_breadth", "腰部横径"},
    Term{"hip_depth", "腰部矢状径"},
    Term{"head_length", "頭長"},
    Term{"head_breadth", "頭幅"},
    Term{"head_depth", "頭長"},
    Term{"face_breadth", "頬骨弓幅"},
    Term{"face_height", "形態学顔高"},
    Term{"nose_breadth", "鼻幅"},
    Term{"nose_height", "鼻高"},
    Term{"pupil_distance", "瞳孔間距離(推定)"},
    Term{"temple_to_ear_left", "側頭から耳介付着部(左)"},
    Term{"temple_to_ear_right", "側頭から耳介付着部(右)"},
    Term{"chest_front_arc", "前胸囲(脇線間)"},
    Term{"chest_back_arc", "後胸囲(脇線間)"},
    Term{"bust_front_arc", "前バスト囲(脇線間)"},
    Term{"bust_back_arc", "後バスト囲(脇線間)"},
    Term{"waist_front_arc", "前胴囲(脇線間)"},
    Term{"waist_back_arc", "後胴囲(脇線間)"},
    Term{"hip_front_arc", "前腰囲(脇線間)"},
    Term{"hip_back_arc", "後腰囲(脇線間)"},
    Term{"across_chest", "胸幅"},
    Term{"across_back", "背幅"},
    Term{"bust_point_to_bust_point", "乳頭間隔"},
    Term{"shoulder_breadth", "肩幅"},
    Term{"shoulder_slope_left", "肩傾斜(左)"},
    Term{"shoulder_slope_right", "肩傾斜(右)"},
    Term{"neck_to_waist_front", "前丈(体表)"},
    Term{"neck_to_waist_back", "背丈(体表)"},
    Term{"neck_to_waist_front_tape", "前丈"},
    Term{"neck_to_waist_back_tape", "背丈"},
    Term{"waist_to_hip_front", "腰丈 前(体表)"},
    Term{"waist_to_hip_back", "腰丈 後(体表)"},
    Term{"waist_to_hip_side", "腰丈 脇(体表)"},
    Term{"waist_to_hip_front_tape", "腰丈 前"},
    Term{"waist_to_hip_back_tape", "腰丈 後"},
    Term{"waist_to_hip_side_tape", "腰丈 脇"},
    Term{"waist_to_crotch", "股上丈"},
    Term{"waist_to_crotch_front", "股上丈 前"},
    Term{"waist_to_crotch_back", "股上丈 後"},
    Term{"trunk_volume", "体幹の体積"},
    Term{"trunk_area", "体幹の体表面積"},
    Term{"head_volume", "頭部の体積"},
    Term{"head_area", "頭部の体表面積"},
};

constexpr SheetWords kEnglishWords{
    "Body measurements",
    "Subject",
    "Scan",
    "Units",
    "front",
    "right side",
    "back",
    "Measurement",
    "Value",
    "± 95 %",
    "Seen",
    "Within limit",
    "Numbers show where each tape lies. Solid lines lie on the side you see; dashed lines pass through the body or "
    "behind "
    "it.",
    "± 95 %: the true value lies within this distance of the stated one in 95 of 100 scans, by the measuring noise, "
    "the "
    "smoothing of the surface and the placing of landmarks.",
    "Seen: share of the path that the sensors saw; the rest lies on the smooth surface between seen places.",
    "Within limit: a dot says that the 95 % interval is within the class limit of ISO 20685-1 that is printed beside "
    "it. "
    "It is a statement on this interval, not on conformity with the standard.",
    "Page"};

constexpr SheetWords kJapaneseWords{
    "人体計測結果",
    "被計測者",
    "スキャン",
    "単位",
    "正面",
    "右側面",
    "背面",
    "計測項目",
    "計測値",
    "± 95 %",
    "実測率",
    "許容内",
    "番号は各項目の計測位置を示します。実線は手前に見える部分、破線は体の内部または裏側を通る部分です。",
    "± 95 %:計測雑音、曲面の平滑化、計測点の位置決めを考慮したとき、真の値が計測値からこの範囲に入る確率が95 "
    "%であることを示します。",
    "実測率:計測経路のうちセンサーが実際に計測した割合。残りは計測点の間をなめらかに結ぶ曲面上の長さです。",
    "許容内:●は95 %信頼区間が併記のISO 20685-1の区分限界値以内にあることを示します。この区間についての記述であり、"
    "規格への適合を示すものではありません。",
    "ページ"};

bool StartsWithAny(std::string_view id, std::initializer_list<std::string_view> prefixes) {
  for (const std::string_view prefix : prefixes) {
    if (id.starts_with(prefix)) return true;
  }
  return false;
}

}  // namespace

std::optional<SheetLanguage> SheetLanguageFromName(std::string_view name) {
  if (name == "en") return SheetLanguage::kEnglish;
  if (name == "ja") return SheetLanguage::kJapanese;
  return std::nullopt;
}

SheetGroup GroupOf(const Measurement& measurement) {
  const std::string_view id = measurement.id;
  if (measurement.unit == "deg") return SheetGroup::kAngles;
  if (measurement.unit != "mm") return SheetGroup::kVolumes;
  if (StartsWithAny(id, {"head_", "face_", "nose_", "pupil_", "temple_", "ear_"})) return SheetGroup::kHead;
  if (id.ends_with("_girth") || id.ends_with("_perimeter")) return SheetGroup::kGirths;
  if (id.ends_with("_height") || id == "stature") return SheetGroup::kHeights;
  if (id.ends_with("_breadth") || id.ends_with("_depth")) return SheetGroup::kBreadths;
  return SheetGroup::kLengths;
}

std::string_view GroupTitle(SheetGroup group, SheetLanguage language) {
  struct Title {
    std::string_view english;
    std::string_view japanese;
  };
  constexpr std::array<Title, kSheetGroups> kTitles{{{"Girths", "周径"},
                                                     {"Lengths over the body", "体表の長さ"},
                                                     {"Breadths and depths", "横径・矢状径"},
                                                     {"Heights above the floor", "高径"},
                                                     {"Head and face", "頭部・顔面"},
                                                     {"Angles", "角度"},
                                                     {"Volumes and areas", "体積・表面積"}}};
  const Title& title = kTitles.at(static_cast<std::size_t>(group));
  return language == SheetLanguage::kJapanese ? title.japanese : title.english;
}

std::string TermIn(const Measurement& measurement, SheetLanguage language) {
  if (language == SheetLanguage::kJapanese) {
    for (const Term& term : kTerms) {
      if (term.id == measurement.id) return std::string(term.japanese);
    }
  }
  return measurement.term;
}

const SheetWords& WordsIn(SheetLanguage language) {
  return language == SheetLanguage::kJapanese ? kJapaneseWords : kEnglishWords;
}

}  // namespace annulus
