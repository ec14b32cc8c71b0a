// The module: text in, text out. It imports nothing, so this file serves page and node alike.
export class Loop {
  static async load(bytes) {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new Loop(instance.exports);
  }

  constructor(exports) {
    this.exports = exports;
  }

  // Bytes into the module's buffer. Making room may grow its memory, so memory is looked at afterwards.
  put(bytes) {
    const at = this.exports.palpate_room(bytes.length);
    new Uint8Array(this.exports.memory.buffer, at, bytes.length).set(bytes);
  }

  // Asks, and returns what `ok` has; what went wrong is thrown as the sentence that it is.
  ask(request) {
    this.put(new TextEncoder().encode(JSON.stringify(request)));
    const length = this.exports.palpate_call();
    const bytes = new Uint8Array(this.exports.memory.buffer, this.exports.palpate_text(), length);
    const answer = JSON.parse(new TextDecoder().decode(bytes));
    if ("error" in answer) throw new Error(answer.error);
    return answer.ok;
  }

  // Hands over the texture model, which is no part of the module.
  model(bytes) {
    this.put(bytes);
    this.exports.palpate_model();
  }
}
