// Words of the glasses designer.
import { language, wordsOf, type Words } from '../core/words';

export const glassesWords = {
  add: ['Add', '追加'],
  adjusted: ['Adjusted so that it can be made', '製作できるように調整しました'],
  advice: ['What to change', '改善のために'],
  amber: ['amber', '琥珀'],
  anti_reflective: ['Anti-reflective', '反射防止'],
  as_style: ['Shape as the style has it', 'スタイルの形に戻す'],
  black: ['black', '黒'],
  blue: ['blue', '青'],
  brighter: ['Brightness', '明るさ'],
  brighter_word: ['brighter', '明るい'],
  brown: ['brown', '茶'],
  brushed: ['Brushed metal', 'ヘアライン'],
  cancel: ['Cancel', '中止'],
  carved: ['Carved', '彫り'],
  clipped: ['(as vivid as a screen can show)', '（画面で表せる最大の鮮やかさ）'],
  coating: ['Coating', 'コーティング'],
  colour: ['Colour', '色'],
  colour_bar: ['Colour bar', 'カラーバー'],
  contacts: ['Where it bears', '接触箇所'],
  contact_part: ['Part', '部品'],
  contact_gap: ['Gap, mm', '隙間 mm'],
  contact_load: ['Share of the weight', '荷重の割合'],
  confirm_name: ['Who answers for PDs and heights', 'PDとアイポイントの確認者'],
  confirm_hint: ['A lab file leaves only with a name.', 'レンズ加工データの出力には確認者名が必要です。'],
  darker_word: ['darker', '暗い'],
  design_a: ['Design A', 'デザインA'],
  design_b: ['Design B', 'デザインB'],
  designer: ['Glasses designer', 'メガネデザイン'],
  drawing_label: ['The frame from the front', 'フレームの正面図'],
  dull_word: ['dull', 'くすんだ'],
  edit: ['Edit {name}', '{name}を編集'],
  expired_fit: ['The design has changed since this fit.', 'このフィッティングの後にデザインが変わりました。'],
  export_dcs: ['Lab file (.dcs)', 'レンズ加工データ (.dcs)'],
  export_json: ['Design (.json)', 'デザイン (.json)'],
  export_pdf: ['Order sheet (.pdf)', '注文書 (.pdf)'],
  export_step: ['Solid (.step)', 'ソリッド (.step)'],
  export_stl: ['Print (.stl)', '3Dプリント (.stl)'],
  file_ready: ['{name} is ready', '{name}ができました'],
  first_step: ['Start', '開始'],
  fit: ['Fit', 'かけ具合'],
  fit_bad: ['Does not fit yet', 'まだ合っていません'],
  fit_first: ['Fit it on first.', '先にフィッティングしてください。'],
  fit_good: ['Fits', '合っています'],
  fit_run: ['Fit it on and check', 'フィッティングして確認'],
  fit_score: ['Score {score} of 100', '評価 {score} / 100'],
  fit_table: ['Distances and angles', '距離と角度'],
  fit_value: ['Value ± 95 %', '値 ± 95 %'],
  fit_range: ['Usual range', '通常の範囲'],
  fit_yes: ['✓ within', '✓ 範囲内'],
  fit_no: ['✗ outside', '✗ 範囲外'],
  fit_what: ['What', '項目'],
  fit_weight: ['Weight {grams} g with lenses of {lenses} g; the nose carries {nose} %.', '重さ{grams} g（レンズ{lenses} g）、鼻に{nose} %の荷重。'],
  fit_enters: ['It would enter the head by {mm} mm.', '頭部に{mm} mm入り込みます。'],
  from_left: ['Left 45°', '左45°'],
  from_right: ['Right 45°', '右45°'],
  front: ['Front', '正面'],
  gold: ['gold', '金'],
  gradient: ['Paler or darker below', '上下で濃さを変える'],
  green: ['green', '緑'],
  half: ['Which half', '上下の選択'],
  history: ['History', '履歴'],
  horn: ['Horn', '角'],
  lens_note: ['With a prescription, its power is shown.', '処方があるときは処方の度で表示します。'],
  lenses: ['Lenses', 'レンズ'],
  left: ['Left', '左'],
  light: ['Light', '照明'],
  library: ['Library', '一覧'],
  library_first: ['Puts every style and size of the library on this head and ranks them.', 'すべてのスタイルとサイズをこの頭部にかけて順位を付けます。'],
  library_run: ['Rank all frames', 'すべて順位付け'],
  load: ['Load', '読み込む'],
  look: ['Colours', '色'],
  lower: ['Lower half', '下側'],
  lower_as_upper: ['Lower half as the upper', '下側も上側と同じにする'],
  lower_transmittance: ['Transmittance at the lower edge', '下端の透過率'],
  loading: ['Loading the head …', '頭部モデルを読み込み中…'],
  material: ['Material', '材質'],
  metal: ['Metal', '金属'],
  mirror: ['Mirror', 'ミラー'],
  more_shape: ['More of the shape', '形の詳細'],
  no_designs: ['Nothing saved yet.', '保存したデザインはありません。'],
  none: ['None', 'なし'],
  order: ['Order and files', '注文とファイル'],
  pearl: ['Pearl', 'パール'],
  picture: ['True picture', '高品質画像'],
  picture_close: ['Close the picture', '画像を閉じる'],
  picture_here: ['From here', 'この向き'],
  picture_of: ['{name}, {view}', '{name}、{view}'],
  picture_running: ['{share} % of the rays', '光線の{share} %'],
  picture_done: ['Finished', '完成'],
  picture_three: ['3 views', '3方向'],
  picture_waiting: ['Waiting …', '待機中…'],
  plain: ['Plain', '無地'],
  plastic: ['Plastic', 'プラスチック'],
  power: ['Power', '度数'],
  prescription: ['Prescription', '処方'],
  preview_failed: ['Not shown: {why}', '表示できません：{why}'],
  rank: ['Rank', '順位'],
  red: ['red', '赤'],
  remove: ['Remove', '削除'],
  rgb: ['Red, green, blue', '赤・緑・青'],
  right: ['Right', '右'],
  redo: ['Redo', 'やり直す'],
  rx_add_d: ['Addition', '加入度'],
  rx_add_differs: ['the additions differ; is that so?', '加入度が左右で違います。よろしいですか。'],
  rx_axis_alone: ['there is an axis but no cylinder', '軸がありますが乱視度がありません。'],
  rx_axis_deg: ['Axis', '軸'],
  rx_axis_missing: ['a cylinder needs an axis', '乱視度には軸が必要です。'],
  rx_confirmed_by: ['PDs and heights confirmed by (empty: estimate)', 'PD・アイポイントの確認者（空欄：推定値）'],
  rx_cyl_d: ['Cylinder', '乱視度'],
  rx_cyl_signs: ['one cylinder is plus, the other minus; is that so?', '乱視度の符号が左右で違います。よろしいですか。'],
  rx_date: ['give a date', '日付を入力してください。'],
  rx_date_label: ['Date', '日付'],
  rx_height_mm: ['Fitting height', 'アイポイント高さ'],
  rx_missing: ['is missing', '入力してください。'],
  rx_none: ['Without prescription', '処方なし'],
  rx_not_a_number: ['is not a number', '数値ではありません。'],
  rx_pd_apart: ['the two PDs are more than 4 mm apart; measured from the nose?', '左右のPDの差が4 mmを超えています。鼻の中心からの値ですか。'],
  rx_pd_mm: ['PD from the nose', '片眼PD'],
  rx_pd_one: ['only one PD is given', '片方のPDしかありません。'],
  rx_prescriber: ['who prescribed it?', '処方者を入力してください。'],
  rx_prescriber_label: ['Prescriber', '処方者'],
  rx_quarter: ['is not in steps of 1/8 D; is that so?', '1/8 D刻みではありません。よろしいですか。'],
  rx_range: ['must be {low} … {high}', '{low}～{high}の範囲で入力してください。'],
  rx_signs: ['one eye is plus, the other minus; is that so?', '球面度の符号が左右で違います。よろしいですか。'],
  rx_sph_d: ['Sphere', '球面度'],
  rx_sum: ['sphere and cylinder together exceed 30 D', '球面度と乱視度の合計が30 Dを超えています。'],
  rx_use: ['Use this prescription', 'この処方を使う'],
  rx_vertex: ['Refracted at, mm ({low} … {high})', '検査時の頂点間距離 mm（{low}～{high}）'],
  samples: ['Sample colours', 'サンプルカラー'],
  save: ['Save', '保存'],
  save_over: ['Save again', '上書き保存'],
  saved: ['Saved', '保存'],
  saved_as: ['“{name}” is saved', '「{name}」を保存しました'],
  shape: ['Shape', '形'],
  silver: ['silver', '銀'],
  size: ['Size', 'サイズ'],
  size_free: ['as drawn', '図のまま'],
  split: ['Two designs', '2つを比較'],
  split_end: ['One design', '1つに戻す'],
  step_load: ['Load “{name}”', '「{name}」を読み込む'],
  step_rank: ['From the library: {name}', '一覧から：{name}'],
  step_style: ['Style', 'スタイル'],
  style: ['Style', 'スタイル'],
  take: ['Try it on', 'かけてみる'],
  texture: ['Texture', 'テクスチャ'],
  texture_scale: ['Size of the pattern', '模様の大きさ'],
  tint: ['Lens colour', 'レンズの色'],
  title: ['Title', '名前'],
  tortoiseshell: ['Tortoiseshell', 'べっ甲'],
  translucent: ['Translucent', '半透明'],
  transmittance: ['Transmittance', '透過率'],
  undo: ['Undo', '元に戻す'],
  unavailable: ['This browser cannot show 3-D pictures (no WebGL). Use another browser, or the true picture.', 'このブラウザでは3D表示（WebGL）が使えません。別のブラウザか高品質画像をお使いください。'],
  upper: ['Upper half', '上側'],
  view_label: ['The head with the glasses. Arrow keys turn, + and − zoom, 1 front, 2 and 3 from the sides.', 'メガネをかけた頭部。矢印キーで回転、+と−で拡大縮小、1で正面、2と3で左右から。'],
  vivid: ['Vividness', '鮮やかさ'],
  vivid_word: ['vivid', '鮮やか'],
  why: ['Why', '理由'],
} as const;

export const tGlasses = wordsOf(glassesWords);

/** Day and time in the person's language, by this machine's clock. */
export function dateText(time_ms: number): string {
  return new Date(time_ms).toLocaleString(language.value === 'ja' ? 'ja-JP' : 'en-GB', { dateStyle: 'medium', timeStyle: 'short' });
}

/** Names of a frame's fields by their options. */
const fieldTable: Words = {
  'upper-outer': ['Upper outer corner [1]', '上部外側 [1]'],
  'upper-inner': ['Upper inner corner [2]', '上部内側 [2]'],
  'upper-thickness': ['Upper thickness [1, 2]', '上部の太さ [1,2]'],
  'lower-outer': ['Lower outer corner [3]', '下部外側 [3]'],
  'lower-inner': ['Lower inner corner [4]', '下部内側 [4]'],
  'lower-thickness': ['Lower thickness [3, 4]', '下部の太さ [3,4]'],
  height: ['Height of the rim [5]', '縦の大きさ [5]'],
  'bridge-height': ['Height of the bridge [6]', 'ブリッジの高さ [6]'],
  width: ['Width of the rim', 'リムの幅'],
  rim: ['Rim', 'リム'],
  bridge: ['Bridge', 'ブリッジ'],
  pads: ['Nose pads', '鼻パッド'],
  temple: ['Temples', 'テンプル'],
  hinge: ['Hinges', '丁番'],
  'bridge-gap': ['Between the rims', 'リムの間隔'],
  depth: ['Depth of the frame', 'フレームの厚み'],
  'arm-height': ['Height of the temples', 'テンプルの高さ'],
  'arm-width': ['Width of a temple', 'テンプルの幅'],
  'groove-depth': ['Depth of the groove', '溝の深さ'],
  'groove-width': ['Width of the groove', '溝の幅'],
  'bridge-forward': ['Bridge forward', 'ブリッジの前出し'],
  'bridge-rise': ['Bridge upward', 'ブリッジの持ち上げ'],
  'lens-edge': ['Lens edge at the screw', 'ねじ部のレンズ厚'],
  'frame-curve': ['Curve of the front', 'フロントカーブ'],
  'face-form': ['Face-form angle', 'そり角'],
  'end-piece': ['End piece', '智の長さ'],
  'temple-outset': ['Temples outward', 'テンプルの張り出し'],
  'tip-length': ['Length of the tip', 'モダンの長さ'],
  'tip-drop': ['Drop of the tip', 'モダンの曲げ角'],
  'pad-length': ['Length of a pad', 'パッドの長さ'],
  'pad-width': ['Width of a pad', 'パッドの幅'],
};

/** Words and sentences of the frame library, by the English that the server sends. */
const frameTable: Words = {
  'quite square': ['square', '四角い'],
  'extremely round': ['round', '丸い'],
  'quite thin': ['thin', '細い'],
  'quite thick': ['thick', '太い'],
  'quite small': ['small', '小さい'],
  'quite large': ['large', '大きい'],
  'quite low': ['low', '低い'],
  'quite high': ['high', '高い'],
  full: ['full', 'フルリム'],
  half: ['half', 'ハーフリム'],
  rimless: ['rimless', 'リムレス'],
  straight: ['straight', 'まっすぐ'],
  saddle: ['saddle', 'サドル'],
  keyhole: ['keyhole', 'キーホール'],
  none: ['none', 'なし'],
  fixed: ['fixed', '固定'],
  adjustable: ['adjustable', '調整式'],
  paper: ['as in the paper', '論文の形'],
  skull: ['along the skull', '頭に沿う'],
  barrel: ['barrel', '三枚丁番'],
  "paper's frame example 1: nearly a square": ['paper’s example 1: nearly a square', '論文の例1：ほぼ四角'],
  "paper's frame example 2: nearly a circle": ['paper’s example 2: nearly a circle', '論文の例2：ほぼ円'],
  "paper's frame example 3: low, square above, round below": ['paper’s example 3: low, square above, round below', '論文の例3：低く、上は四角く下は丸い'],
  "paper's frame example 4: strong upper rim (d1 : d2 = 3 : 1), lower outer corner cut away": ['paper’s example 4: strong upper rim, lower outer corner cut away', '論文の例4：上部が太く、下部外側を落とした形'],
  'circle in acetate with a saddle bridge': ['circle in acetate with a saddle bridge', '丸・アセテート・サドルブリッジ'],
  'circle with a keyhole bridge': ['circle with a keyhole bridge', '丸・キーホールブリッジ'],
  'low and round': ['oval: low and round', 'オーバル'],
  'square with eased corners': ['square with eased corners', 'スクエア'],
  'square with well rounded corners': ['square with well rounded corners', '角の丸いスクエア'],
  'low rectangle': ['low rectangle', '長方形'],
  'broad above, round below: between round and wellington': ['boston: broad above, round below', 'ボストン'],
  'boston with larger fixed pads and a low bridge for a flat nose': ['boston with larger pads for a flat nose', 'ボストン（低いブリッジ）'],
  'strong, broad top, sides that come in towards rounded lower corners': ['wellington: strong, broad top', 'ウェリントン'],
  'heavy, straight brow and sides, round below': ['D frame: heavy, straight brow', 'Dフレーム'],
  'heavy brow over a thin lower rim': ['browline: heavy brow over a thin rim', 'ブロー'],
  'heavy brow, the lens held below by a nylon cord': ['browline with a nylon cord below', 'ブロー（ナイロール）'],
  'outer corners drawn up and out, cut away below': ['cat-eye', 'キャットアイ'],
  'wide, high outside, small towards the nose': ['butterfly', 'バタフライ'],
  'large soft square for sunglasses': ['oversize: large soft square', 'オーバーサイズ'],
  'low reading frame to look over': ['half-eye: low reading frame', 'ハーフアイ（読書用）'],
  'wrapped round the face, deeply curved': ['sport: wrapped round the face', 'スポーツ（ラップ）'],
  'small circle with large pads': ['children’s: small circle', '子供用・丸'],
  'small soft rectangle': ['children’s: small soft rectangle', '子供用・長方形'],
  'round with a slightly flattened top, temples set high': ['panto: flattened top, high temples', 'パント'],
  'the classic small panto in wire with a saddle bridge': ['P3: small panto in wire', 'P3（メタルパント）'],
  'drop-shaped: flat above, cut away towards the nose below': ['aviator: drop-shaped', 'ティアドロップ'],
  'squared aviator': ['navigator: squared aviator', 'ナビゲーター'],
  'low rectangle in metal': ['low rectangle in metal', 'メタル・長方形'],
  'circle in wire': ['circle in wire', 'メタル・丸'],
  'eight sides with soft corners: between square and round': ['octagon with soft corners', 'オクタゴン'],
  'six sides with soft corners: flat above and below, drawn out at the middle of the sides': ['hexagon with soft corners', 'ヘキサゴン'],
  'rectangle with a metal brow and a nylon cord below': ['half-rim rectangle', 'ナイロール・長方形'],
  'oval with a metal brow and a nylon cord below': ['half-rim oval', 'ナイロール・オーバル'],
  'oval lenses screwed to bridge and end pieces': ['rimless oval', 'リムレス・オーバル'],
  'rectangular lenses screwed to bridge and end pieces': ['rimless rectangle', 'リムレス・長方形'],
};

/** What the fit report is about, and what to do when it is below or above its range. */
const goalTable: Record<string, { term: readonly [string, string]; below: readonly [string, string]; above: readonly [string, string] }> = {
  pd: { term: ['Pupil from the middle (PD)', '片眼PD'], below: ['lens centre too far out: choose a narrower frame', 'レンズ中心が外側です。幅の狭いフレームを選びます。'], above: ['lens centre too far in: choose a wider frame', 'レンズ中心が内側です。幅の広いフレームを選びます。'] },
  pupil_height: { term: ['Fitting height', 'アイポイント高さ'], below: ['frame sits too high: choose a wider or higher bridge', '位置が高すぎます。鼻幅の広い、または高いブリッジを選びます。'], above: ['frame sits too low: choose a narrower or lower bridge', '位置が低すぎます。鼻幅の狭い、または低いブリッジを選びます。'] },
  vertex_distance: { term: ['Vertex distance', '頂点間距離'], below: ['lens too near to the eye: bend the pads, or choose a narrower bridge', 'レンズが目に近すぎます。パッドを調整するか鼻幅の狭いものを選びます。'], above: ['lens too far from the eye: bend the pads, or choose a wider bridge', 'レンズが目から遠すぎます。パッドを調整するか鼻幅の広いものを選びます。'] },
  pantoscopic_tilt: { term: ['Pantoscopic tilt', '前傾角'], below: ['tilt too small: bend the temples’ joints', '前傾角が小さすぎます。テンプルの付け根を曲げます。'], above: ['tilt too large: bend the temples’ joints', '前傾角が大きすぎます。テンプルの付け根を曲げます。'] },
  face_form: { term: ['Face-form angle', 'そり角'], below: ['too flat: bend the bridge or choose a more curved front', 'そり角が小さすぎます。ブリッジを曲げるかカーブの強いものを選びます。'], above: ['too curved: bend the bridge or choose a flatter front', 'そり角が大きすぎます。ブリッジを曲げるか平らなものを選びます。'] },
  dbl: { term: ['Between the lenses (DBL)', '鼻幅（DBL）'], below: ['too narrow for this nose', '鼻幅が狭すぎます。鼻幅の広いものか調整式パッドを選びます。'], above: ['too wide for this nose', '鼻幅が広すぎます。鼻幅の狭いものか調整式パッドを選びます。'] },
  temple_length: { term: ['Temple to its bend', 'テンプル（曲がりまで）'], below: ['choose shorter temples', '短いテンプルを選びます。'], above: ['choose longer temples', '長いテンプルを選びます。'] },
  temple_splay: { term: ['Temple splay', 'テンプルの開き'], below: ['front too wide for this head: choose a narrower frame', 'フロントが広すぎます。幅の狭いフレームを選びます。'], above: ['front too narrow for this head: choose a wider frame', 'フロントが狭すぎます。幅の広いフレームを選びます。'] },
  lash_clearance: { term: ['Lashes to the lens', 'まつ毛との距離'], below: ['move the lenses forward by pads or bridge', 'パッドかブリッジでレンズを前に出します。'], above: ['', ''] },
  skin_clearance: { term: ['Brow and cheek to the frame', '眉・頬との距離'], below: ['choose a less high frame or less tilt', '縦の小さいフレームにするか前傾角を減らします。'], above: ['', ''] },
  nose_balance: { term: ['Right flank’s share of the nose', '鼻の左右バランス'], below: ['the left flank carries more: bend the pads', '左側の荷重が大きい：パッドを調整します。'], above: ['the right flank carries more: bend the pads', '右側の荷重が大きい：パッドを調整します。'] },
};

function inLanguage(pair: readonly [string, string]): string {
  return pair[language.value === 'ja' ? 1 : 0];
}

export function fieldWord(option: string, otherwise: string): string {
  const pair = fieldTable[option];
  return pair ? inLanguage(pair) : otherwise;
}

/** A style's name: short in English, what it is in Japanese. */
export function styleWord(id: string, description: string): string {
  if (language.value === 'ja') return frameWord(description);
  const paper = /^example(\d)$/.exec(id)?.[1];
  if (paper) return `Paper’s example ${paper}`;
  return (id.charAt(0).toUpperCase() + id.slice(1)).replaceAll('-', ' ');
}

export function lightWord(light: string): string {
  const key = `light_${light}`;
  return key in glassesWords ? tGlasses(key as keyof typeof glassesWords) : light;
}

export function frameWord(english: string): string {
  const pair = frameTable[english];
  return pair ? inLanguage(pair) : english;
}

/** Name of a goal of the fit ("pd_right") and what to do about it if it is not met. */
export function goalWords(goal: { id: string; term: string; value: number; low: number; met: boolean; advice?: string }): { term: string; advice: string } {
  const side = /_(right|left)$/.exec(goal.id)?.[1] as 'right' | 'left' | undefined;
  const known = goalTable[goal.id.replace(/_(right|left)$/, '')];
  if (!known) return { term: goal.term, advice: goal.advice ?? '' };
  const term = inLanguage(known.term) + (side ? (language.value === 'ja' ? `（${tGlasses(side)}）` : `, ${tGlasses(side).toLowerCase()}`) : '');
  if (goal.met) return { term, advice: '' };
  // The server's sentence holds the numbers; it is English.
  const own = inLanguage(goal.value < goal.low ? known.below : known.above);
  return { term, advice: language.value === 'en' && goal.advice ? goal.advice : own || (goal.advice ?? '') };
}

/** Where a frame touches the head, by the names of the fit report. */
const contactTable: Record<string, readonly [string, string]> = {
  pad_right: ['right pad', '鼻パッド（右）'],
  pad_left: ['left pad', '鼻パッド（左）'],
  bridge_right: ['bridge, right', 'ブリッジ（右）'],
  bridge_left: ['bridge, left', 'ブリッジ（左）'],
  temple_right: ['right temple', 'テンプル（右）'],
  temple_left: ['left temple', 'テンプル（左）'],
};

export function contactWord(part: string): string {
  const pair = contactTable[part];
  return pair ? inLanguage(pair) : part.replaceAll('_', ' ');
}

/** Why a frame has its rank. The server's sentence holds the numbers; it is English. */
export function rankWords(frame: { why: string; goals?: readonly Parameters<typeof goalWords>[0][] }): string {
  if (language.value === 'en') return frame.why;
  if (frame.why === 'fits') return tGlasses('fit_good');
  const goal = frame.goals?.find((one) => one.advice === frame.why);
  if (goal) return goalWords(goal).advice;
  if (frame.why.includes('enter the head')) return '頭部に入り込みます。幅の広いフレームを選びます。';
  return frame.why.startsWith('temple') ? 'テンプルが頭に触れません。内側に曲げます。' : '鼻に触れません。ほかのブリッジか調整式パッドを選びます。';
}

/** How the frame was put on: the server's sentence in English, what it comes to otherwise. */
export function placementWords(placement: string | undefined, english: string): string {
  if (language.value === 'en' || !english) return english;
  if (placement === 'fit') return 'フィッティングの位置（概算）';
  return placement === 'last' ? '合わせられないため、前のフレームの位置に表示しています。' : '論文の4つの手順による位置';
}

/** "upper-outer: 3 mm given, 4 mm used: why", as the server says what it changed. */
export function adjustedWords(english: string): string {
  const found = /^([a-z-]+): (.+) given, (.+) used: /.exec(english);
  if (language.value === 'en' || !found) return english;
  const [, field = '', given = '', used = ''] = found;
  const shown = (text: string): string => frameWord(text).replace(' degrees', '°').replace('dioptres', 'D');
  return `${fieldWord(field, field)}：${shown(given)} → ${shown(used)}（作れる範囲に直しました）`;
}
