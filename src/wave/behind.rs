//! The background writer: a destination on a thread of its own, so that formatting a waveform does not wait until it is
//! packed and written.
//!
//! What is written is handed over in large pieces, in order, so the bytes are those of the destination itself. A fault is
//! told at the next piece, or at the end.

use std::io::{self, Seek, SeekFrom, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use super::output::{Destination, Piece};
use super::thread::{ended, over, refused};

/// How many pieces may wait.
const WAITING: usize = 4;

enum Order {
    Write(Piece),
    Seek(SeekFrom),
    Complete,
}

/// A [`Destination`] that does what another does, on another thread.
pub struct Behind<D> {
    state: State<D>,
}

enum State<D> {
    New(D),
    Running {
        orders: SyncSender<Order>,
        /// Buffers that can be used again.
        empty: Receiver<Vec<u8>>,
        /// Where the destination is after it was moved in.
        places: Receiver<u64>,
        thread: JoinHandle<io::Result<()>>,
    },
    /// It failed, or is complete.
    Over,
}

impl<D: Destination + Seek + Send + 'static> Behind<D> {
    /// The thread starts with the first that is to be written.
    pub fn new(destination: D) -> Behind<D> {
        Behind { state: State::New(destination) }
    }

    fn order(&mut self, order: Order) -> io::Result<()> {
        if let State::New(_) = self.state {
            self.start()?;
        }
        let State::Running { orders, .. } = &self.state else { return Err(over()) };
        if orders.send(order).is_ok() { Ok(()) } else { self.join() }
    }

    fn start(&mut self) -> io::Result<()> {
        let State::New(mut destination) = std::mem::replace(&mut self.state, State::Over) else { return Err(over()) };
        let (orders, to_do) = sync_channel::<Order>(WAITING);
        let (used, empty) = sync_channel(WAITING + 1);
        let (at, places) = sync_channel(1);
        let work = move || {
            for order in to_do {
                match order {
                    Order::Write(piece) => {
                        let bytes = piece.bytes();
                        destination.write_all(&bytes)?;
                        // if there are enough, or nobody takes it, it is dropped
                        let _ = used.try_send(bytes);
                    }
                    Order::Seek(to) => _ = at.send(destination.seek(to)?),
                    Order::Complete => return destination.complete(),
                }
            }
            Ok(())
        };
        let thread = std::thread::Builder::new().name("output".to_owned()).spawn(work).map_err(|e| refused(&e))?;
        self.state = State::Running { orders, empty, places, thread };
        Ok(())
    }
}

impl<D> Behind<D> {
    /// Waits for the thread to end.
    fn join(&mut self) -> io::Result<()> {
        let State::Running { orders, empty, places, thread } = std::mem::replace(&mut self.state, State::Over) else {
            return Err(over());
        };
        drop((orders, empty, places));
        ended(thread, "writes to the file")
    }
}

impl<D: Destination + Seek + Send + 'static> Write for Behind<D> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.order(Order::Write(Piece::Made(bytes.to_vec())))?;
        Ok(bytes.len())
    }

    /// What is on its way arrives without it.
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<D: Destination + Seek + Send + 'static> Seek for Behind<D> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.order(Order::Seek(to))?;
        let State::Running { places, .. } = &self.state else { return Err(over()) };
        match places.recv() {
            Ok(place) => Ok(place),
            Err(_) => Err(self.join().err().unwrap_or_else(over)),
        }
    }
}

impl<D: Destination + Seek + Send + 'static> Destination for Behind<D> {
    fn complete(&mut self) -> io::Result<()> {
        self.order(Order::Complete)?;
        self.join()
    }

    fn give(&mut self, piece: Piece) -> io::Result<Vec<u8>> {
        self.order(Order::Write(piece))?;
        let State::Running { empty, .. } = &self.state else { return Err(over()) };
        Ok(empty.try_recv().unwrap_or_default())
    }
}

/// Nothing stays behind: what is half done is taken away before this returns.
impl<D> Drop for Behind<D> {
    fn drop(&mut self) {
        if matches!(self.state, State::Running { .. }) {
            let _ = self.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Output;

    #[test]
    fn all_arrives_in_order_also_after_going_back() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        let mut behind = Behind::new(Output::create(&path).unwrap());
        behind.write_all(b"head ").unwrap();
        let mut expected = b"HEAD ".to_vec();
        for i in 0..100_u8 {
            let bytes = vec![i; 1000 + usize::from(i)];
            expected.extend(&bytes);
            let piece = if i % 2 == 0 { Piece::Made(bytes) } else { Piece::Later(Box::new(move || bytes)) };
            behind.give(piece).unwrap();
        }
        assert_eq!(behind.stream_position().unwrap(), expected.len() as u64);
        behind.seek(SeekFrom::Start(0)).unwrap();
        behind.write_all(b"HEAD").unwrap();
        behind.complete().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), expected);
        assert!(behind.write_all(b"more").is_err());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_fault_is_told_and_ends_it() {
        let mut behind = Behind::new(Output::create(std::path::Path::new("/dev/full")).unwrap());
        let error = (0..100).find_map(|_| behind.give(Piece::Made(vec![0; 1000])).err()).expect("a fault");
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        assert!(behind.complete().is_err());
    }

    #[test]
    fn dropped_before_it_is_complete_nothing_is_left() {
        let dir = tempfile::tempdir().unwrap();
        let mut behind = Behind::new(Output::create(&dir.path().join("a")).unwrap());
        behind.write_all(b"half").unwrap();
        drop(behind);
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
    }
}
