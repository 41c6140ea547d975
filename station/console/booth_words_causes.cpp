// What every cause of a stop means to somebody in a shop.

#include <array>

#include "station/console/booth_words.h"

namespace annulus {
namespace {

struct CauseWords {
  const char* text_en;
  const char* advice_en;
  const char* text_ja;
  const char* advice_ja;
};

/// In the order of CauseCode.
constexpr std::array<CauseWords, kCauseCodes> kWords{{
    {"The emergency stop was pressed, the door was opened, or the ring reached its end switch.",
     "See that the customer is well. Pull the emergency stop out, shut the door, then press the reset button.",
     "非常停止が押されたか、扉が開いたか、リングが端のスイッチに達しました。",
     "お客様が無事か確かめてください。非常停止を引き出し、扉を閉めてから、リセットボタンを押してください。"},
    {"The safety switches or relays are not as they should be.",
     "Press the reset button once. If this comes back, do not use the booth; call the technician.",
     "安全スイッチまたはリレーの状態が正しくありません。",
     "リセットボタンを一度押してください。また出る場合は使用を中止し、技術者を呼んでください。"},
    {"The two halves of the emergency stop do not agree.", "Do not use the booth. Call the technician.",
     "非常停止の二つの回路が一致していません。", "使用を中止し、技術者を呼んでください。"},
    {"A safety relay did not switch off.", "Do not use the booth. Call the technician.", "安全リレーが切れていません。",
     "使用を中止し、技術者を呼んでください。"},
    {"The ring sinks although it should stand still.",
     "Let nobody into the booth. Press the emergency stop and call the technician.",
     "停止しているはずのリングが下がっています。",
     "誰も中に入れないでください。非常停止を押し、技術者を呼んでください。"},
    {"The motor of the ring does not answer.",
     "Acknowledge this and move the ring home again. If it comes back, call the technician.",
     "リングのモーターが応答しません。",
     "確認を押し、もう一度リングを原点に戻してください。また出る場合は技術者を呼んでください。"},
    {"The motor of the ring reports a fault.",
     "Acknowledge this and move the ring home again. If it comes back, call the technician.",
     "リングのモーターが異常を知らせています。",
     "確認を押し、もう一度リングを原点に戻してください。また出る場合は技術者を呼んでください。"},
    {"The motor of the ring is not set as it was.", "Do not use the booth. Call the technician.",
     "モーターの設定が変わっています。", "使用を中止し、技術者を呼んでください。"},
    {"The ring was not where it should have been: something may be in its way.",
     "See that nothing touches the ring, then acknowledge and move it home again.",
     "リングが予定の位置にありませんでした。何かが当たっているかもしれません。",
     "リングに触れている物がないか確かめ、確認を押して原点に戻してください。"},
    {"The height of the ring jumped.",
     "Acknowledge this and move the ring home. If it comes back, call the technician.",
     "リングの高さの値が飛びました。", "確認を押し、原点に戻してください。また出る場合は技術者を呼んでください。"},
    {"The ring did not find its home position.",
     "See that nothing is in the way of the ring, acknowledge, then try again.",
     "リングが原点を見つけられませんでした。",
     "リングの通り道に物がないか確かめ、確認を押してもう一度お試しください。"},
    {"The ring reached the end of its travel.", "Acknowledge this and move the ring home again.",
     "リングが移動範囲の端に達しました。", "確認を押し、原点に戻してください。"},
    {"The ring moved without being told to.", "Let nobody into the booth. Call the technician.",
     "指示していないのにリングが動きました。", "誰も中に入れないでください。技術者を呼んでください。"},
    {"The ring went the wrong way.", "Let nobody into the booth. Call the technician.",
     "リングが逆の方向に動きました。", "誰も中に入れないでください。技術者を呼んでください。"},
    {"The ring was faster than it may be.", "Let nobody into the booth. Call the technician.",
     "リングが決められた速さを超えました。", "誰も中に入れないでください。技術者を呼んでください。"},
    {"The ring did not stop in time and was stopped hard.",
     "Acknowledge this and move the ring home. If it comes back, call the technician.",
     "リングが時間内に止まらず、強制的に止めました。",
     "確認を押し、原点に戻してください。また出る場合は技術者を呼んでください。"},
    {"A group of sensors does not answer.",
     "Acknowledge this and scan again. If it comes back, call the technician: a plug may be loose.",
     "一部のセンサーが応答しません。",
     "確認を押し、もう一度測ってください。また出る場合は技術者を呼んでください（コネクターの緩みなど）。"},
    {"The line to the sensors failed.", "Acknowledge this and scan again. If it comes back, call the technician.",
     "センサーとの通信が切れました。", "確認を押し、もう一度測ってください。また出る場合は技術者を呼んでください。"},
    {"Too much of what the sensors sent was damaged.",
     "Acknowledge this and scan again. If it comes back, call the technician.",
     "センサーからのデータに壊れたものが多すぎました。",
     "確認を押し、もう一度測ってください。また出る場合は技術者を呼んでください。"},
    {"Several sensors see nothing.", "Wipe the sensors' windows with a soft dry cloth, acknowledge, scan again.",
     "いくつかのセンサーが何も捉えていません。",
     "センサーの窓を柔らかい乾いた布で拭き、確認を押してもう一度測ってください。"},
    {"The light of some sensors is not as it should be.", "Do not use the booth. Call the technician.",
     "一部のセンサーの光が正常ではありません。", "使用を中止し、技術者を呼んでください。"},
    {"Other sensors are plugged in than the booth knows.", "Call the technician.",
     "登録されているものと違うセンサーが接続されています。", "技術者を呼んでください。"},
    {"The booth's computer was too busy.", "Close other programs on it, acknowledge, scan again.",
     "装置のコンピューターの処理が間に合いませんでした。",
     "ほかのプログラムを閉じ、確認を押してもう一度測ってください。"},
    {"The booth's program stood still for a moment.", "Acknowledge this and move the ring home again.",
     "装置のプログラムが一時止まりました。", "確認を押し、原点に戻してください。"},
    {"A part of the booth's program has stopped.",
     "Restart the booth's computer. If it comes back, call the technician.", "装置のプログラムの一部が止まりました。",
     "装置のコンピューターを再起動してください。また出る場合は技術者を呼んでください。"},
    {"The booth's computer has no memory left.", "Restart the booth's computer.",
     "装置のコンピューターのメモリーが足りません。", "装置のコンピューターを再起動してください。"},
    {"The booth's computer is too hot, or its supply is too low.",
     "See that air can get to the computer, wait some minutes, then acknowledge.",
     "装置のコンピューターが熱くなりすぎたか、電源の電圧が低すぎます。",
     "通気を確かめ、数分待ってから確認を押してください。"},
    {"The scan could not be written to the disk.",
     "What was taken is kept. Acknowledge; if it comes back, call the technician.",
     "測定データをディスクに書き込めませんでした。",
     "そこまでのデータは残っています。確認を押してください。また出る場合は技術者を呼んでください。"},
    {"The disk is full.", "Call the technician or administrator: old recordings have to be moved away.",
     "ディスクがいっぱいです。", "技術者か管理者を呼んでください。古い記録を移す必要があります。"},
    {"Customer, consent or calibration are not in order.", "Read what is not ticked in the list, and put it right.",
     "お客様、同意、または校正の確認が済んでいません。", "一覧で印のない項目を読み、直してください。"},
    {"This kind of scan does not fit the booth.", "Choose another kind of scan, or call the technician.",
     "この測定の種類は、この装置では行えません。", "別の種類を選ぶか、技術者を呼んでください。"},
    {"The booth's program made a mistake.", "Acknowledge this and move the ring home. Tell the technician.",
     "装置のプログラムに誤りがありました。", "確認を押し、原点に戻してください。技術者に知らせてください。"},
}};

}  // namespace

PlainWords WordsOfCause(CauseCode code, SheetLanguage language) {
  const CauseWords& words = kWords.at(static_cast<std::size_t>(code));
  if (language == SheetLanguage::kJapanese) return {words.text_ja, words.advice_ja};
  return {words.text_en, words.advice_en};
}

}  // namespace annulus
