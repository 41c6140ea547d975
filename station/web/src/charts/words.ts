// Words of the charts.
import { wordsOf } from '../core/words';

export const tCharts = wordsOf({
  all: ['Show all', '全体を表示'],
  further: ['Zoom out (−)', '縮小 (−)'],
  map_keys: [
    'Arrow keys move the cursor, with Shift by ten; + and − zoom, 0 shows all.',
    '矢印キーでカーソル移動（Shiftで10ずつ）、＋と−で拡大・縮小、0で全体表示。',
  ],
  nearer: ['Zoom in (+)', '拡大 (+)'],
  no_return: ['no return', '戻り光なし'],
  ring_label: [
    'The ring seen from above. Front is up, the subject’s right is on the right. Arrow keys choose a sensor.',
    'リングを上から見た図。上が前、右が被測定者の右側。矢印キーでセンサーを選びます。',
  ],
  board: ['B{n}', 'B{n}'],
  front: ['front', '前'],
  back: ['back', '後'],
  right: ['right', '右'],
  left: ['left', '左'],
});
