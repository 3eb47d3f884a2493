//! dev only
use lacuna::simulate::hidden::{Choice, Draw, Family, hidden};
use std::io::Write;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let seed: u64 = a[1].parse().unwrap();
    let dir = &a[2];
    let choices: Vec<Choice> = a[3..]
        .chunks(3)
        .map(|c| Choice {
            family: Family::named(&c[0]).unwrap(),
            joint: c[1].parse::<usize>().unwrap() - 1,
            strength: c[2].parse().unwrap(),
        })
        .collect();
    let Draw::Data(d) = hidden(&choices, seed).unwrap() else { panic!("excluded") };
    std::fs::create_dir_all(dir).unwrap();
    let write = |name: &str, log: &lacuna::log::Log| {
        let mut f = std::io::BufWriter::new(std::fs::File::create(format!("{dir}/{name}.csv")).unwrap());
        let n = log.q.len();
        let mut h = vec!["t".to_string()];
        for k in ["q", "dq", "tau"] {
            for j in 1..=n {
                h.push(format!("{k}{j}"));
            }
        }
        for c in log.channels.keys() {
            h.push(c.clone());
        }
        writeln!(f, "{}", h.join(",")).unwrap();
        for k in 0..log.t.len() {
            let mut row = vec![format!("{:?}", log.t[k])];
            for j in 0..n {
                row.push(format!("{:?}", log.q[j][k]));
            }
            for j in 0..n {
                row.push(format!("{:?}", log.dq.as_ref().unwrap()[j][k]));
            }
            for j in 0..n {
                row.push(format!("{:?}", log.tau[j][k]));
            }
            for c in log.channels.values() {
                row.push(format!("{:?}", c[k]));
            }
            writeln!(f, "{}", row.join(",")).unwrap();
        }
    };
    for (k, log) in d.fit.iter().enumerate() {
        write(&format!("fit{}", k + 1), log);
    }
    for (k, log) in d.reference.iter().enumerate() {
        write(&format!("ref{}", k + 1), log);
    }
    write("unseen", &d.unseen);
    println!("noise {:?}", d.noise);
    for s in &d.secrets {
        println!("{} {:?} {} size {}", s.family, s.joint, s.strength, s.size);
    }
}
