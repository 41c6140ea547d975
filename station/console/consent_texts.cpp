#include "station/console/consent_texts.h"

#include <algorithm>
#include <array>

namespace annulus {
namespace {

constexpr std::string_view kVersion = "2026-11";
constexpr std::array<std::string_view, 4> kPurposes{"measure", "glasses", "reshape", "research"};

ConsentText English(const std::string& days) {
  return {
      std::string(kVersion),
      "en",
      "Your body scan: what we do with it, and what you decide",
      {"A ring of distance sensors moves along your body and measures its outer shape. It uses harmless light, does "
       "not touch you, and takes about half a minute. No photograph is taken.",
       "From the scan this station works out a model of your shape, and measurements. The shape of a body can say "
       "something about health. We therefore treat it as specially protected data (Article 9 of the GDPR): only with "
       "your explicit consent, and only for what you tick below.",
       "The scan, the model and your name stay on this station, encrypted with a key of your own. Nothing is sent "
       "anywhere unless you ask for it or take it with you.",
       "We keep your data for " + days +
           " days and then delete it. You can have it deleted at any time, at once: your key is destroyed, and what "
           "it had locked can never be read again, in backups neither once their keys have been destroyed (at the "
           "latest after 30 days).",
       "You can see your data, have it corrected, and take a copy with you. You can withdraw this consent at any "
       "time, without giving a reason and without any disadvantage; what was done until then stays lawful. You can "
       "also complain to the data protection authority.",
       "You may stop the scan at any moment: say so, press the call button, or step out when the ring stands still. "
       "Your body is not shown on the screen until you allow it."},
      {{"measure", "I agree to be scanned, and to measurements of my body being taken from the scan."},
       {"glasses", "I agree to the shape of my head being used to design and try on glasses."},
       {"reshape", "I agree to the model of my body being reshaped on the screen (what would it look like if …)."},
       {"research",
        "I agree to the model without my name being used to make the measuring better. This is not needed for "
        "anything else."}}};
}

ConsentText Japanese(const std::string& days) {
  return {
      std::string(kVersion),
      "ja",
      "身体の測定について：データの扱いと、お客様にお決めいただくこと",
      {"距離センサーの輪が身体に沿って動き、外側の形を測ります。人体に無害な光を使い、身体には触れません。時間は約30秒"
       "です。"
       "写真は撮りません。",
       "測定データから、この装置が身体の形のモデルと寸法を計算します。身体の形からは健康について何かが分かることがあり"
       "ます。"
       "そのため、特に保護が必要な個人データ（GDPR第9条、要配慮個人情報に準じるもの）として扱い、お客様の明示の同意があ"
       "る場合に、"
       "下で印を付けた目的だけに使います。",
       "測定データ、モデル、お名前は、お客様専用の鍵で暗号化してこの装置の中に保管します。お客様が求めない限り、外へ送"
       "ることは"
       "ありません。",
       "データは" + days +
           "日間保管し、その後消去します。いつでもすぐに消去を求めることができます。専用の鍵を破棄しますので、その鍵で"
           "守られていた"
           "データは二度と読めません。バックアップも、その鍵が破棄された後（遅くとも30日後）は読めません。",
       "ご自分のデータを見ること、直すこと、写しを受け取ることができます。同意はいつでも、理由を述べずに、不利益を受け"
       "ることなく"
       "取り消せます。取り消すまでに行われたことは適法なままです。個人データ保護の監督機関に申し立てることもできます。",
       "測定はいつでもやめられます。声をかけるか、呼び出しボタンを押すか、輪が止まっているときに外へ出てください。お客"
       "様が"
       "お許しになるまで、身体は画面に表示されません。"},
      {{"measure", "身体を測定し、その結果から寸法を求めることに同意します。"},
       {"glasses", "眼鏡の設計と試着のために、頭部の形を使うことに同意します。"},
       {"reshape", "画面上で身体のモデルの形を変えてみることに同意します。"},
       {"research",
        "測定を良くするために、氏名を除いたモデルを使うことに同意します。（ほかのことには必要ありません）"}}};
}

}  // namespace

ConsentText ConsentTextIn(SheetLanguage language, int keep_days) {
  const std::string days = std::to_string(keep_days);
  return language == SheetLanguage::kJapanese ? Japanese(days) : English(days);
}

std::string_view ConsentTextVersion() { return kVersion; }

bool IsConsentPurpose(std::string_view id) {
  return std::find(kPurposes.begin(), kPurposes.end(), id) != kPurposes.end();
}

}  // namespace annulus
