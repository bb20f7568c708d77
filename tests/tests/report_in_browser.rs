//! The report of `repro` as a browser shows it: on a wide window, on a phone, printed, without a network.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "helpers of a test, which clippy does not take for tests"
)]

use airlight_tests::browser::Browser;
use airlight_tests::cli::Desk;
use serde_json::Value;

/// Widths of a desktop's window and of a phone; units: CSS pixels.
const WIDTHS: [u64; 2] = [1280, 390];

/// Writes what it finds in the page to the page that it is framed by.
const PROBE: &str = r##"<script>
addEventListener("load", () => {
  const all = (selector) => Array.from(document.querySelectorAll(selector));
  const name = (element) => element.outerHTML.slice(0, 120);
  const outside = (selector, attribute) => all(selector)
    .map((element) => element.getAttribute(attribute))
    .filter((to) => !/^(data:|#)/.test(to));
  const light = (colour) => {
    const [r, g, b] = colour.match(/[\d.]+/g).map((v) => v / 255).map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const colour = getComputedStyle(at).backgroundColor;
      if (!/^rgba\(.*, 0\)$/.test(colour)) return colour;
    }
    return "rgb(255, 255, 255)";
  };
  const contrast = (element) => {
    const [a, b] = [getComputedStyle(element).color, ground(element)].map(light);
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  };
  const root = document.documentElement;
  parent.postMessage({
    width: innerWidth,
    scroll: root.scrollWidth,
    language: root.lang,
    landmarks: ["header", "main", "nav"].map((tag) => all(tag).length),
    headings: all("h1, h2, h3, h4, h5, h6").map((heading) => Number(heading.tagName[1])),
    images: document.images.length,
    unseen: all("img").filter((image) => image.naturalWidth === 0).map(name),
    silent: all("img").filter((image) => !image.alt.trim()).map(name)
      .concat(all("main svg").filter((svg) => svg.getAttribute("role") !== "img" || !svg.getAttribute("aria-label")).map(name)),
    drawings: all("main svg").length,
    tables: all("table").length,
    headless: all("table").filter((table) => !table.caption || !table.querySelector("thead th[scope=col]")).map(name),
    nameless: all("tbody tr").filter((row) => row.querySelectorAll("th[scope=row]").length !== 1).map(name),
    ragged: all("table").filter((table) => new Set(Array.from(table.rows, (row) => row.cells.length)).size > 1).map(name),
    // what scrolls sideways can be reached by the keyboard and says what it is
    stuck: all("main *").filter((element) => element.scrollWidth > element.clientWidth + 1
        && ["auto", "scroll"].includes(getComputedStyle(element).overflowX)
        && (element.tabIndex !== 0 || !element.getAttribute("aria-label"))).map(name),
    lost: all("a[href^='#']").filter((link) => !document.getElementById(link.hash.slice(1))).map(name),
    doubled: all("[id]").filter((element) => all(`[id="${element.id}"]`).length > 1).map(name),
    // the first thing that a keyboard reaches
    first: document.querySelector("a, button, [tabindex]").hash,
    outside: outside("[src]", "src").concat(outside("[href]", "href")),
    fetched: performance.getEntriesByType("resource").map((entry) => entry.name).filter((to) => !to.startsWith("data:")),
    pale: all("p, dt, dd, th, td, li, a, summary, figcaption, .quiet, .holds, .fails")
      .filter((element) => contrast(element) < 4.5).map((element) => contrast(element).toFixed(2) + " " + name(element)),
  }, "*");
});
</script>"##;

/// What the probe finds in a window of this width.
///
/// A browser's own window is never as narrow as a phone, so the page is shown in a frame.
fn probed(desk: &Desk, browser: &Browser, width: u64) -> Value {
    let frame = format!(
        "<!DOCTYPE html><body style=\"margin:0\"><script>addEventListener('message', (event) => {{
           const found = document.createElement('pre');
           found.textContent = '@@' + encodeURIComponent(JSON.stringify(event.data)) + '@@';
           document.body.append(found);
         }})</script><iframe src=\"probed.html\" style=\"border:0\" width=\"{width}\" height=\"800\"></iframe></body>"
    );
    desk.write("out/frame.html", frame);
    let document = browser.document(&desk.path("out/frame.html"), (1400, 900));
    // the script's own text has the marks, too
    let found =
        document.split("<pre>@@").nth(1).unwrap_or_else(|| panic!("the probe said nothing: {document}"));
    let found = found.split("@@").next().unwrap();
    serde_json::from_str(&percent_decoded(found)).unwrap()
}

fn percent_decoded(text: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        let mut digit = || char::from(rest.next().unwrap()).to_digit(16).unwrap() as u8;
        bytes.push(if byte == b'%' { 16 * digit() + digit() } else { byte });
    }
    String::from_utf8(bytes).unwrap()
}

fn check_page(found: &Value, width: u64) {
    let number = |key: &str| found[key].as_u64().unwrap_or_else(|| panic!("{key}: {}", found[key]));
    assert_eq!(number("width"), width);
    assert!(number("scroll") <= width, "the page scrolls sideways: {} of {width}", number("scroll"));
    for key in [
        "unseen", "silent", "headless", "nameless", "ragged", "stuck", "lost", "doubled", "outside",
        "fetched", "pale",
    ] {
        let list = found[key].as_array().unwrap_or_else(|| panic!("{key}: {}", found[key]));
        assert!(list.is_empty(), "{key} at {width}: {list:#?}");
    }
    // nothing was looked at in vain
    for (key, least) in [("images", 5), ("drawings", 3), ("tables", 6)] {
        assert!(number(key) >= least, "{} {key}", number(key));
    }
    assert_eq!(found["language"], "en");
    assert_eq!(found["landmarks"], serde_json::json!([1, 1, 1]));
    assert_eq!(found["first"], "#summary", "the keyboard starts at the way past all else");
    let levels: Vec<u64> = found["headings"].as_array().unwrap().iter().filter_map(Value::as_u64).collect();
    assert_eq!(levels.first(), Some(&1));
    assert!(levels.windows(2).all(|pair| pair[1] > 1 && pair[1] <= pair[0] + 1), "{levels:?}");
}

/// A picture of that width with dark letters on light paper, all over it.
fn check_picture((width, height, pixels): (u32, u32, Vec<[u8; 3]>), wanted: (u32, u32)) {
    assert_eq!((width, height), wanted);
    let bands = pixels.chunks(pixels.len() / 4);
    for (index, band) in bands.take(4).enumerate() {
        let share = |test: fn(&[u8; 3]) -> bool| {
            band.iter().filter(|pixel| test(pixel)).count() as f64 / band.len() as f64
        };
        let (ink, paper) = (share(|p| p.iter().all(|v| *v < 90)), share(|p| p.iter().all(|v| *v > 235)));
        assert!(ink > 0.002 && paper > 0.5, "quarter {index} of {wanted:?}: ink {ink}, paper {paper}");
    }
}

#[test]
fn the_report_in_a_browser() {
    let Some(browser) = Browser::find() else { return };
    let desk = Desk::default();
    desk.done("repro error-budget grid-fig11 grid-fig13 --preset smoke --backend cpu --out out/r");
    let report = std::fs::read_to_string(desk.path("out/r/report.html")).unwrap();
    assert!(!report.contains("<script"), "the report needs no script");
    desk.write("out/probed.html", report.replace("</body>", &format!("{PROBE}</body>")));
    for width in WIDTHS {
        check_page(&probed(&desk, &browser, width), width);
    }
    let page = desk.path("out/r/report.html");
    for size in [(1280, 900), (390, 844)] {
        check_picture(browser.picture(&page, size), size);
    }
    let printed = browser.print(&page);
    assert!(printed.starts_with(b"%PDF-") && printed.len() > 50_000, "{} bytes", printed.len());
}
