// Voice and tones for who stands in the booth and sees no screen.
import { Signal } from '../../core/signal';
import { language } from '../../core/words';

export const muted = new Signal(localStorage.getItem('annulus.muted') === 'yes');

export function setMuted(yes: boolean): void {
  localStorage.setItem('annulus.muted', yes ? 'yes' : 'no');
  muted.set(yes);
  if (yes) silence();
}

/** Only voices of this machine: others would send the text away. */
function localVoice(): SpeechSynthesisVoice | null {
  if (!('speechSynthesis' in window)) return null;
  return speechSynthesis.getVoices().find((voice) => voice.localService && voice.lang.startsWith(language.value)) ?? null;
}

/** Says a sentence, if the machine has a voice of its own for the language. */
export function say(text: string): void {
  const voice = localVoice();
  if (muted.value || !voice) return;
  speechSynthesis.cancel();
  const words = new SpeechSynthesisUtterance(text);
  words.voice = voice;
  words.lang = voice.lang;
  words.rate = 0.95;
  speechSynthesis.speak(words);
}

let sound: AudioContext | null = null;

/** Hz and s of what is played one after another. */
const tones = {
  tick: [[660, 0.06]],
  ready: [[660, 0.15], [880, 0.25]],
  start: [[880, 0.5]],
  done: [[660, 0.15], [880, 0.15], [1100, 0.35]],
  trouble: [[330, 0.3], [247, 0.5]],
} as const;
export type Tone = keyof typeof tones;

const kLoudness = 0.2;

export function tone(name: Tone): void {
  if (muted.value || !('AudioContext' in window)) return;
  sound ??= new AudioContext();
  void sound.resume();
  let at = sound.currentTime;
  for (const [frequency, length] of tones[name]) {
    const source = sound.createOscillator();
    const loudness = sound.createGain();
    source.frequency.value = frequency;
    loudness.gain.setValueAtTime(0, at);
    loudness.gain.linearRampToValueAtTime(kLoudness, at + 0.02);
    loudness.gain.setValueAtTime(kLoudness, at + length - 0.03);
    loudness.gain.linearRampToValueAtTime(0, at + length);
    source.connect(loudness).connect(sound.destination);
    source.start(at);
    source.stop(at + length);
    at += length;
  }
}

/** Ends what is being said and played. */
export function silence(): void {
  if ('speechSynthesis' in window) speechSynthesis.cancel();
  void sound?.close();
  sound = null;
}
