/* Runs the search worker in a frame if the site is opened from a file, where browsers refuse workers. */
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super()
      this.onmessage = null
      this.frame = document.createElement("iframe")
      this.frame.hidden = true
      this.queue = []
      window.addEventListener("message", event => {
        if (event.source !== this.frame.contentWindow) return
        const copy = new MessageEvent("message", { data: event.data })
        this.dispatchEvent(copy)
        if (this.onmessage) this.onmessage(copy)
      })
      const source = `<script>
        window.postMessage = data => parent.postMessage(data, "*")
        window.importScripts = (...urls) => Promise.all(urls.map(url => new Promise((resolve, reject) => {
          const script = document.createElement("script")
          Object.assign(script, { src: new URL(url, "${url}").href, onload: resolve, onerror: reject })
          document.body.appendChild(script)
        })))
      <\/script><script src="${url}"><\/script>`
      this.frame.addEventListener("load", () => {
        const waiting = this.queue
        this.queue = null
        for (const data of waiting) this.deliver(data)
      })
      this.frame.srcdoc = `<!doctype html><meta charset="utf-8"><body>${source}</body>`
      document.documentElement.appendChild(this.frame)
    }
    postMessage(data) {
      if (this.queue) this.queue.push(data)
      else this.deliver(data)
    }
    deliver(data) {
      this.frame.contentWindow.dispatchEvent(new MessageEvent("message", { data }))
    }
    terminate() {
      this.frame.remove()
    }
  }
}
