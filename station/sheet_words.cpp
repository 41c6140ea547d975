#include "station/sheet_words.h"

#include <algorithm>
#include <array>

namespace annulus {
namespace {

struct Term {
  std::string_view id;
  std::string_view japanese;
};

/// A measurement of the skin has the entry of the tape over it: its ending is taken off first.
constexpr std::array kTerms{
    Term{"head_girth", "頭囲"},
    Term{"neck_girth", "頸囲"},
    Term{"neck_base_girth", "頸付根囲"},
    Term{"axilla_girth", "腋窩位胸囲"},
    Term{"chest_girth", "胸囲(バスト)"},
    Term{"chest_girth_taut", "胸囲(バスト) 最短巻尺"},
    Term{"under_bust_girth", "下部胸囲(アンダーバスト)"},
    Term{"waist_girth", "胴囲(ウエスト)"},
    Term{"waist_girth_taut", "胴囲(ウエスト) 最短巻尺"},
    Term{"omphalion_girth", "臍位腹囲"},
    Term{"top_hip_girth", "腹囲(ミドルヒップ)"},
    Term{"hip_girth", "腰囲(ヒップ)"},
    Term{"hip_girth_taut", "腰囲(ヒップ) 最短巻尺"},
    Term{"crotch_girth", "股位周囲"},
    Term{"neck_breadth", "頸部横径"},
    Term{"neck_depth", "頸部矢状径"},
    Term{"axilla_breadth", "腋窩位胸部横径"},
    Term{"axilla_depth", "腋窩位胸部矢状径"},
    Term{"chest_breadth", "胸部横径"},
    Term{"chest_depth", "胸部矢状径"},
    Term{"under_bust_breadth", "下部胸部横径"},
    Term{"under_bust_depth", "下部胸部矢状径"},
    Term{"waist_breadth", "胴部横径"},
    Term{"waist_depth", "胴部矢状径"},
    Term{"hip_breadth", "腰部横径"},
    Term{"hip_depth", "腰部矢状径"},
    Term{"head_front_arc", "頭囲 前半"},
    Term{"head_back_arc", "頭囲 後半"},
    Term{"chest_front_arc", "胸囲 前(脇線間)"},
    Term{"chest_back_arc", "胸囲 後(脇線間)"},
    Term{"waist_front_arc", "胴囲 前(脇線間)"},
    Term{"waist_back_arc", "胴囲 後(脇線間)"},
    Term{"hip_front_arc", "腰囲 前(脇線間)"},
    Term{"hip_back_arc", "腰囲 後(脇線間)"},
    Term{"across_chest", "胸幅(腋窩位、脇線間)"},
    Term{"across_back", "背幅(腋窩位、脇線間)"},
    Term{"vertex_height", "身長(頭頂高)"},
    Term{"eye_height", "眼高"},
    Term{"chin_height", "オトガイ高"},
    Term{"head_height", "頭囲位高"},
    Term{"neck_height", "頸囲位高"},
    Term{"cervicale_height", "頸椎高"},
    Term{"front_neck_height", "頸窩高"},
    Term{"side_neck_height_right", "頸側高(右)"},
    Term{"side_neck_height_left", "頸側高(左)"},
    Term{"shoulder_height_right", "肩峰高(右)"},
    Term{"shoulder_height_left", "肩峰高(左)"},
    Term{"axilla_height", "腋窩高"},
    Term{"chest_height", "胸囲位高"},
    Term{"under_bust_height", "アンダーバスト高"},
    Term{"waist_height", "胴高(ウエスト高)"},
    Term{"omphalion_height", "臍高"},
    Term{"top_hip_height", "ミドルヒップ高"},
    Term{"hip_height", "腰高(ヒップ高)"},
    Term{"crotch_height", "股下高"},
    Term{"bust_point_height", "乳頭高"},
    Term{"cervicale_to_waist_drop", "頸椎点からウエストまで(垂直)"},
    Term{"chest_to_waist_drop", "胸囲位からウエストまで(垂直)"},
    Term{"waist_to_hip_drop", "腰丈(垂直)"},
    Term{"body_rise", "股上丈(垂直)"},
    Term{"neck_to_waist_front", "前中心丈"},
    Term{"neck_to_waist_back", "背丈"},
    Term{"scye_depth", "腋窩位背丈(袖ぐり深さ)"},
    Term{"chest_to_waist_front", "胸囲位からウエストまで 前"},
    Term{"waist_to_hip_front", "腰丈 前"},
    Term{"waist_to_hip_back", "腰丈 後"},
    Term{"waist_to_hip_right", "腰丈 右脇"},
    Term{"waist_to_hip_left", "腰丈 左脇"},
    Term{"waist_to_top_hip", "ウエストからミドルヒップまで 右脇"},
    Term{"side_seam_upper", "脇丈(腋窩位からウエストまで)"},
    Term{"bust_point_to_bust_point", "乳頭間隔"},
    Term{"shoulder_breadth", "肩幅(肩峰間距離)"},
    Term{"shoulder_length_right", "小肩幅(右)"},
    Term{"shoulder_length_left", "小肩幅(左)"},
    Term{"shoulder_slope_right", "肩傾斜(右)"},
    Term{"shoulder_slope_left", "肩傾斜(左)"},
    Term{"head_length", "頭長"},
    Term{"head_breadth", "頭幅"},
    Term{"bitragion_breadth", "耳珠間幅"},
    Term{"face_breadth", "頬骨弓幅"},
    Term{"jaw_breadth", "下顎角幅"},
    Term{"temple_breadth", "こめかみ間幅"},
    Term{"face_length", "形態学顔高(セリオン―オトガイ)"},
    Term{"nose_length", "鼻長(セリオン―鼻尖)"},
    Term{"nose_breadth", "鼻幅"},
    Term{"pupil_distance", "瞳孔間距離(推定)"},
    Term{"temple_to_ear_right", "こめかみから耳の付け根まで(右)"},
    Term{"temple_to_ear_left", "こめかみから耳の付け根まで(左)"},
    Term{"head_depth_to_nose", "鼻尖から後頭まで"},
    Term{"bitragion_frontal_arc", "耳珠間前頭弧長"},
    Term{"bitragion_menton_arc", "耳珠間オトガイ弧長"},
    Term{"bitragion_back_arc", "耳珠間後頭弧長"},
    Term{"head_volume", "体積 頸囲位より上(頭部)"},
    Term{"upper_chest_volume", "体積 腋窩位から胸囲位"},
    Term{"chest_to_waist_volume", "体積 胸囲位からウエスト"},
    Term{"waist_to_hip_volume", "体積 ウエストからヒップ"},
    Term{"hip_to_crotch_volume", "体積 ヒップから股位"},
    Term{"head_area", "体表面積 頸囲位より上(頭部)"},
    Term{"upper_chest_area", "体表面積 腋窩位から胸囲位"},
    Term{"chest_to_waist_area", "体表面積 胸囲位からウエスト"},
    Term{"waist_to_hip_area", "体表面積 ウエストからヒップ"},
    Term{"hip_to_crotch_area", "体表面積 ヒップから股位"},
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
  if (id.ends_with("_height") || id.find("_height_") != id.npos) return SheetGroup::kHeights;
  if (StartsWithAny(id, {"head_", "face_", "nose_", "pupil_", "temple_", "bitragion_", "jaw_"}))
    return SheetGroup::kHead;
  if (id.ends_with("_girth") || id.ends_with("_girth_taut") || id.ends_with("_perimeter")) return SheetGroup::kGirths;
  const bool along_skin = measurement.method.starts_with("skin") || measurement.method.starts_with("tape");
  if (!along_skin && (id.ends_with("_breadth") || id.ends_with("_depth"))) return SheetGroup::kBreadths;
  return SheetGroup::kLengths;
}

std::string_view GroupTitle(SheetGroup group, SheetLanguage language) {
  struct Title {
    std::string_view english;
    std::string_view japanese;
  };
  constexpr std::array<Title, kSheetGroups> kTitles{{{"Girths", "周径"},
                                                     {"Lengths and arcs", "長さ・弧長"},
                                                     {"Breadths and depths", "横径・矢状径"},
                                                     {"Heights above the floor", "高径"},
                                                     {"Head and face", "頭部・顔面"},
                                                     {"Angles", "角度"},
                                                     {"Volumes and areas", "体積・表面積"}}};
  const Title& title = kTitles.at(static_cast<std::size_t>(group));
  return language == SheetLanguage::kJapanese ? title.japanese : title.english;
}

std::string TermIn(const Measurement& measurement, SheetLanguage language) {
  if (language == SheetLanguage::kEnglish) return measurement.term;
  std::string id = measurement.id;
  const bool skin = measurement.method == "skin, vertical" || measurement.method == "skin, horizontal";
  if (id.ends_with("_perimeter")) id.replace(id.rfind("_perimeter"), std::string::npos, "_girth");
  if (id.ends_with("_tape")) id.erase(id.rfind("_tape"));
  const auto found = std::find_if(kTerms.begin(), kTerms.end(), [&](const Term& term) { return term.id == id; });
  if (found == kTerms.end()) return measurement.term;
  return std::string(found->japanese) + (skin ? " 体表" : "");
}

const SheetWords& WordsIn(SheetLanguage language) {
  return language == SheetLanguage::kJapanese ? kJapaneseWords : kEnglishWords;
}

}  // namespace annulus
